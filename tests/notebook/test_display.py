"""What a recording shows of itself, as HTML and as text, in both languages."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from math import nan
from pathlib import Path
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from notebook_harness import NOON, of_a_car, of_values

import mikas
from mikas.catalog import shipped
from mikas.client.cars import CarDetails
from mikas.errors import UsageError
from mikas.i18n import Text
from mikas.notebook.html import html_of
from mikas.notebook.overview import ChannelOverview
from mikas.notebook.text import text_of
from mikas.notebook.wording import ChannelLine, List, Wording, worded
from mikas.recording.annotations.events import comment_note
from mikas.recording.capture.reader import Problem
from mikas.recording.capture.writer import append_note
from mikas.recording.table.channels import Channel
from mikas.sampling.events import Gap, LineState, Marker, StateChanged

CYRILLIC = re.compile("[а-яё]", re.IGNORECASE)
SILENT = Text("the ECU is silent", "блок молчит")
EVENTS = (Gap(1.0, 0.5, 1.25, SILENT), Marker(1.5, "knock <b>"), Gap(2.0, 2.0, None))


@pytest.fixture(scope="module")
def car(tmp_path_factory):
    return of_a_car(tmp_path_factory.mktemp("car") / "drive.pcapng", *EVENTS)


def texts(html):
    """The texts of a well-formed piece of HTML, without its style."""
    root = ET.fromstring(html)
    return [it.strip() for each in root.iter() if each.tag != "style" for it in each.itertext()]


def test_a_recording_shows_car_faults_gaps_markers_and_every_channel(car):
    recording = mikas.open(car, language="en")
    html = recording._repr_html_()
    shown = "\n".join(texts(html))
    for words in (
        "drive.pcapng", "Mikas 7.1", "ВИРТУАЛЬНЫЙ БЛОК", "ЗМЗ-4062.10", "a cable", "60 responses",
        "13 – Air mass signal low; the text is from one source", "Check: ",
        "Gaps: 2", "the ECU is silent", "to the end", "knock <b>",
    ):  # fmt: skip
        assert words in shown, words
    rows = ET.fromstring(html).findall(".//table[@class='channels']/tr")[1:]
    assert [row[0].text.split(" ")[0] for row in rows] == [it.name for it in recording.channels]
    assert all(row.find(".//path") is not None for row in rows)
    coolant = next(row for row in rows if row[0].text == "TWAT")
    assert [cell.text for cell in coolant][1:5] == ["Coolant temperature", "°C", "86", "86"]


def test_a_recording_speaks_the_language_of_its_reader(car, monkeypatch):
    monkeypatch.setenv("MIKAS_LANG", "ru")
    recording = mikas.open(car)
    russian = recording._repr_html_()
    for words in (
        "Ошибки в памяти блока",
        "Низкий уровень",
        "блок молчит",
        "Параметр",
        "60 ответов",
    ):
        assert words in russian
    monkeypatch.setenv("MIKAS_LANG", "en")
    english = [it for it in texts(recording._repr_html_()) if CYRILLIC.search(it)]
    assert all("ВИРТУАЛЬНЫЙ" in it or "ЗМЗ" in it for it in english)  # the passport's own
    assert recording.language == "en"
    assert mikas.open(car, language="ru").language == "ru"


def test_all_of_it_is_in_the_piece_itself(car):
    html = mikas.open(car)._repr_html_()
    assert not re.search(r"<script|<link|<img|url\(|https?:|@import|\bon\w+=", html)
    colours = re.findall(r"#[0-9a-f]{3,6}|rgb|background: (?!none)", html.split("</style>")[0])
    assert colours == []  # those of the notebook, dark or light


def test_the_text_says_the_same(car):
    recording = mikas.open(car, language="en")
    lines = str(recording).splitlines()
    assert lines[0] == "drive.pcapng"
    for words in ("Mikas 7.1", "13 – Air mass signal low", "Gaps: 2", "knock <b>"):
        assert any(words in line for line in lines), words
    for channel in recording.channels:
        assert any(line.startswith(f"{channel.name} ") for line in lines)
    assert repr(recording).startswith(
        f"<Recording {str(car)!r}: {len(recording.channels)} channels: TWAT"
    )
    pieces = []
    recording._repr_pretty_(SimpleNamespace(text=pieces.append), cycle=False)
    assert pieces == [str(recording)]


def test_times_are_those_of_tables_and_of_the_day(tmp_path):
    path = of_values(
        tmp_path / "it.pcapng",
        [(n / 10, 20 + n % 3) for n in range(50)],
        Marker(NOON + 2.5, "hill"),
        Gap(NOON + 1, NOON + 1, NOON + 2),
        StateChanged(NOON + 1.5, LineState.ECHO_ONLY, reason=SILENT),
    )
    append_note(path, comment_note(NOON, "after the repair"))
    shown = "\n".join(texts(mikas.open(path, language="en")._repr_html_()))
    assert re.search(r"2\.5 s \(\d\d:\d\d:22\): hill", shown)
    assert re.search(r"1\.0 s \(\d\d:\d\d:21\), 1 s: echo, but the ECU is silent", shown)
    assert "after the repair" in shown
    assert "Stored faults\nnot read in this recording" in shown
    assert "\n800\n880\n10\n" in re.sub(r"\n+", "\n", shown)  # least, most, values a second


def test_what_was_erased_or_is_gone_is_told_from_what_is_stored(car):
    recording = mikas.open(car, language="en")
    overview = recording.overview
    (reading,) = overview.faults.readings
    later = replace(reading, codes=(55,))
    faults = replace(overview.faults, readings=(reading, later))
    lists = worded(recording, replace(overview, faults=faults), "en").lists
    assert [each.lines for each in lists if each.title == "No longer stored"] == [["13"]]
    assert lists[0].lines[0].startswith("55 – ")
    none = replace(overview.faults, readings=(replace(reading, codes=()),))
    assert worded(recording, replace(overview, faults=none), "en").lists[0].lines == ["none"]


def test_long_lists_end_with_a_count(tmp_path):
    gaps = [Gap(NOON + n, NOON + n, NOON + n + 0.1) for n in range(500)]
    path = of_values(tmp_path / "it.pcapng", [(0, 20), (600, 21)], *gaps)
    html = mikas.open(path, language="en")._repr_html_()
    assert "… and 488 more" in html
    assert "Gaps: 500, 50 s in all" in html
    assert html.count("<li>") < 20


def test_a_file_that_is_gone_is_said_in_words(car, tmp_path):
    path = tmp_path / "gone.pcapng"
    path.write_bytes(car.read_bytes())
    recording = mikas.open(path, language="en")
    path.unlink()
    for shown in ("\n".join(texts(recording._repr_html_())), str(recording)):
        assert "gone.pcapng" in shown
        assert "no such file" in shown.lower()
        assert "Traceback" not in shown
    path.write_bytes(car.read_bytes())  # it is back
    assert "Mikas 7.1" in recording._repr_html_()


def test_a_course_is_interrupted_as_the_plot_is(tmp_path):
    """By a gap that was noted, and by a minute without values; a slow channel is not."""
    lively = [n / 10 for n in range(20)]
    for number, (times, pieces, events) in enumerate(
        (
            ([*lively, *(60 + t for t in lively)], 2, ()),
            ([n / 10 for n in range(1200)], 1, ()),
            ([*(n / 10 for n in range(600)), *(600 + n / 10 for n in range(600))], 2, ()),
            ([n * 5.0 for n in range(30)], 1, ()),
            (lively, 2, [Gap(NOON + 1.05, NOON + 1.05, NOON + 1.1)]),
        )
    ):
        values = [(time, 20 + at % 3) for at, time in enumerate(times)]
        path = of_values(tmp_path / f"{number}.pcapng", values, *events)
        html = mikas.open(path)._repr_html_()
        drawn = ET.fromstring(html).find(".//path").attrib["d"]
        assert drawn.count("M") == pieces, times


def test_damage_is_shown_and_the_rest_too(car, tmp_path):
    path = tmp_path / "damaged.pcapng"
    data = bytearray(car.read_bytes())
    data[len(data) // 2 : len(data) // 2 + 40] = b"\xff" * 40
    path.write_bytes(bytes(data))
    html = mikas.open(path, language="en")._repr_html_()
    assert "Damage in the file" in html
    assert "TWAT" in html


def test_a_recording_without_values_is_shown_as_empty(tmp_path):
    path = of_values(tmp_path / "empty.pcapng", [])
    recording = mikas.open(path, language="en")
    assert "0 responses" in recording._repr_html_()
    assert "0 responses" in str(recording)
    named = mikas.open(path, names=["UOZ", "FREQ"], language="en")
    assert named._repr_html_().count("no values") == 2
    rows, _ = named.window(0, 1)
    assert {name: len(column) for name, column in rows.values.items()} == {"UOZ": 0, "FREQ": 0}
    absent = mikas.open(of_values(tmp_path / "a.pcapng", [(0, 20), (1, 20)]), names=["UOZ", "FREQ"])
    assert "no values" in absent._repr_html_() or "нет значений" in absent._repr_html_()


hostile = st.text(
    st.one_of(st.characters(), st.sampled_from("<>&\"'\0\x1b\u202e\ud800\ufffe$_")), max_size=30
)
numbers = st.floats(allow_nan=True, allow_infinity=True)


@given(hostile, st.lists(hostile, min_size=6, max_size=6), st.lists(st.tuples(numbers, numbers)))
def test_hostile_texts_are_escaped(text, cells, curve):
    wording = Wording(
        "ru", text, [(text, text)], [List(text, [text, "<script>"], text)], (text,) * 6,
        [ChannelLine(tuple(cells), tuple(sorted(curve)))],
    )  # fmt: skip
    root = ET.fromstring(html_of(wording))
    assert {each.tag for each in root.iter()} <= {
        "div", "style", "p", "table", "tr", "th", "td", "ul", "li", "svg", "path",
    }  # fmt: skip
    assert {key for each in root.iter() for key in each.attrib} <= {
        "class", "lang", "viewBox", "role", "d",
    }  # fmt: skip
    assert "<script>" in "".join(root.itertext())
    assert text_of(wording).encode()
    assert "\x1b" not in text_of(wording)


@given(hostile, st.one_of(st.none(), numbers))
def test_hostile_facts_are_shown_without_trouble(once, text, number):
    overview = once.overview
    channel = Channel(once.channels[0].name, text, Text(text, text), decimals=2)
    shown = replace(
        overview,
        summary=replace(overview.summary, car=CarDetails(text, text), note=text, length=2e12),
        channels=(ChannelOverview(channel, False, 1, number, number, None, number, ((0.0, nan),)),),
        gaps=((Gap(0.0, -1e300, 1e300), Text(text, text)),),
        markers=(Marker(1e18, text),),
    )
    assert ET.fromstring(html_of(worded(once, shown, "en"))) is not None
    assert text_of(worded(once, shown, "ru"))


@pytest.fixture(scope="module")
def once(car):
    return mikas.open(car, language="en")


def test_a_hostile_file_name_is_escaped(car, tmp_path):
    path = tmp_path / "<img src=x onerror=alert(1)>\x1b[2J.pcapng"
    path.write_bytes(car.read_bytes())
    html = mikas.open(path)._repr_html_()
    assert ET.fromstring(html).find(".//img") is None
    assert "<img" not in html


def test_problems_have_their_offsets(car):
    recording = mikas.open(car, language="ru")
    problem = Problem(4711, Text("a block", "блок <x>"))
    shown = SimpleNamespace(
        path=Path("a.pcapng"), catalog=shipped(), about={}, interpretation="literal",
        problems=(problem,), problem_count=14,
    )  # fmt: skip
    wording = worded(shown, recording.overview, "ru")
    assert wording.lists[-1] == List("Повреждения файла", ["4711: блок <x>"], "… и ещё 13")
    assert ("Толкование", "literal") in wording.facts


def test_a_language_that_there_is_not_is_refused(car):
    with pytest.raises(UsageError, match="There is no language “de”"):
        mikas.open(car, language="de")
