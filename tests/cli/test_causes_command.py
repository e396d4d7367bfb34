"""`mikas causes`: over recordings, measured now, causes of one's own, and what is refused."""

from __future__ import annotations

import sys

import pytest

LEAK = "duration = 400\n[start]\nrunning = true\ncoolant = 86\n[condition]\nleak = 9\n"
OWN = """\
id = "gremlin"
complaints = ["hunts"]
[text]
en = "A gremlin"
[check]
en = "Look for it."
[effects]
idle-hunting = 5
"""


@pytest.fixture(scope="module")
def made_once():
    """What the first test that needs the recording has made: its result, and the file's bytes."""
    return []


@pytest.fixture
def leaking(mikas, tmp_path, made_once):
    """A recording of three minutes of warm idle with an air leak."""
    if not made_once:
        (tmp_path / "leak.toml").write_text(LEAK, "utf-8")
        port = "--port", "sim:?clock=simulated&scenario=leak.toml"
        ran = mikas(*port, "causes", "--duration", "150", "--capture", "leak.pcapng", "--json")
        assert ran.status == 0
        made_once[:] = ran.object, (tmp_path / "leak.pcapng").read_bytes()
    found, recorded = made_once
    (tmp_path / "leak.pcapng").write_bytes(recorded)
    return found


def test_a_leak_is_ranked_first_now_and_from_the_recording(mikas, leaking):
    first = leaking["causes"][0]
    assert (leaking["verdict"], first["id"]) == ("causes", "leak")
    assert leaking["files"] == []
    again = mikas("causes", "leak.pcapng", "--json").object
    assert again["causes"] == leaking["causes"]
    assert again["files"] == ["leak.pcapng"]
    evidence = first["for"][0]
    assert evidence["text"]["ru"].startswith("коррекция смеси")
    assert 0 <= evidence["from"] < evidence["to"]
    assert evidence["recording"] == 0
    assert {"test", "why", "guided", "text"} <= again["next"][0].keys()


def test_people_read_the_verdict_the_moments_and_the_doubt(mikas, leaking):
    words = mikas("causes", "leak.pcapng", "leak.pcapng", "--complaint", "idles-high").out
    assert words.startswith("What was seen speaks for: Air leak")
    assert "1. Almost certainly: Air leak" in words
    assert "leak.pcapng: between 0:0" in words
    assert "not from cars" in words
    russian = mikas("causes", "leak.pcapng", "--lang", "ru").out
    assert "1. Почти наверняка: Подсос воздуха" in russian
    assert "Что измерить дальше:" in russian


@pytest.mark.parametrize("columns", [60, 80])
@pytest.mark.parametrize("language", ["en", "ru"])
def test_a_terminal_shows_whole_words_within_its_width(
    mikas, leaking, monkeypatch, columns, language
):
    command = "causes", "leak.pcapng", "--lang", language
    plain = mikas(*command)
    assert max(map(len, plain.lines)) > 100  # a paragraph is a line for the next program
    monkeypatch.setenv("COLUMNS", str(columns))
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    wrapped = mikas(*command)
    assert max(map(len, wrapped.lines)) <= columns
    assert sorted(wrapped.out.split()) == sorted(plain.out.split())  # no word is cut or lost
    check = next(it for it in wrapped.lines if it.strip().startswith(("Check:", "Проверить:")))
    following = wrapped.lines[wrapped.lines.index(check) + 1]
    assert following.startswith("   ")
    assert len(following) - len(following.lstrip()) == 3


def test_causes_of_one_s_own_count_and_a_wrong_file_is_reported_with_its_line(mikas, leaking):
    folder = mikas.home / "config/mikas/causes"
    folder.mkdir(parents=True)
    (folder / "gremlin.toml").write_text(OWN, "utf-8")
    (folder / "wrong.toml").write_text(OWN.replace("idle-hunting", "nonsense"), "utf-8")
    ran = mikas("causes", "leak.pcapng", "--json")
    assert ran.status == 0
    (error,) = ran.object["errors"]
    assert (error["file"].endswith("wrong.toml"), error["line"]) == (True, 8)
    assert "wrong.toml" in ran.err
    assert "nonsense" in ran.err


def test_what_the_unit_can_t_separate_is_measured_by_hand(mikas):
    port = "--port", "sim:?clock=simulated&scenario=mixed&car=alternator:0.4"
    ran = mikas(*port, "causes", "--duration", "700", "--capture", "weak.pcapng", "--json")
    assert ran.status == 0
    first, *others = ran.object["next"]
    assert (first["test"], first["guided"]) == ("by-hand", False)
    assert [each["cause"] for each in first["outcomes"]] == ["alternator", "regulator"]
    assert others
    assert not any(each["outcomes"] for each in others)
    words = " ".join(mikas("causes", "weak.pcapng").out.split())
    assert "A voltmeter at the battery’s terminals, at 2500 rpm" in words
    assert "below that with everything off: Alternator gives too little current" in words


def test_files_of_different_cars_are_refused_with_their_names(mikas, tmp_path):
    for plate in ("A123BC77", "K456MH50"):
        mikas("log", "-o", f"{plate}.pcapng", "FREQ", "--count", "5", "--plate", plate)
    ran = mikas("causes", "A123BC77.pcapng", "K456MH50.pcapng")
    assert ran.status == 2
    assert "A123BC77" in ran.err
    assert "K456MH50.pcapng" in ran.err
    assert mikas("causes", "A123BC77.pcapng", "A123BC77.pcapng").status == 0
    both = b"".join((tmp_path / f"{it}.pcapng").read_bytes() for it in ("A123BC77", "K456MH50"))
    (tmp_path / "both.pcapng").write_bytes(both)
    ran = mikas("causes", "both.pcapng")
    assert ran.status == 2
    assert "mikas split" in ran.err
    assert mikas("report", "both.pcapng", "-o", "both.html").status == 0  # of the last car


def test_the_report_has_the_causes_in_a_section_of_its_own(mikas, leaking, tmp_path):
    assert mikas("report", "leak.pcapng", "-o", "leak.html", "--lang", "ru").status == 0
    page = (tmp_path / "leak.html").read_text("utf-8")
    assert "<strong>Подсос воздуха мимо ДМРВ</strong>: почти наверняка" in page
    assert "а не по машинам" in page
    ran = mikas("report", "leak.pcapng", "-o", "leak.html", "--overwrite", "--json").object
    assert ran["outcome"] == "attention"
    assert ran["verdict"]["ru"].startswith("Почти наверняка: Подсос воздуха мимо ДМРВ. ")
    assert ran["causes"]["causes"] == leaking["causes"]
