"""The dissector in Wireshark's own engine says what `mikas decode` says, frame by frame.

Wireshark shows the packets of merged ports in the file's order, `mikas decode` one port after the
other. So the captures are those that `opened_capture` gives; `merged` shows that the order is all.

Skipped where there is no tshark, unless `MIKAS_REQUIRE_TSHARK` is set: then that is a failure.
"""

from __future__ import annotations

import json
import os
import re
import shutil
from pathlib import Path

import pytest

from dissectors import oracle_harness as oracle
from dissectors.sessions_harness import (
    INBOUND,
    OUTBOUND,
    crafted,
    hostile,
    section,
    sessions_of_program,
    vectors,
)
from dissectors.tshark_harness import TSHARK, decoded, run, shown
from mikas.catalog import load, shipped
from mikas.dissectors.wireshark.generator import source
from mikas.dissectors.wireshark.labels import LABELS
from mikas.framing import encode
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.opening import opened_capture

pytestmark = pytest.mark.skipif(
    shutil.which(TSHARK) is None and not os.environ.get("MIKAS_REQUIRE_TSHARK"),
    reason="tshark is not installed",
)
ROOT = Path(__file__).parents[2]
REASONS = ("checksum", "too long", "unfinished")
REPLACED = {"the response does not fit", "refused", "stored fault"}  # by a text that says more
HOSTILE = 120 if os.environ.get("HYPOTHESIS_PROFILE") == "ci" else 16  # lines


def plugin(path, catalog=None, language="en", interpretation="corrected"):
    text = source(catalog or shipped(), language, interpretation, "0")
    path.write_text(text, "utf-8")
    return path


@pytest.fixture(scope="module")
def script(tmp_path_factory):
    return plugin(tmp_path_factory.mktemp("wireshark") / "mikas.lua")


@pytest.fixture(scope="module")
def merged(tmp_path_factory):
    """All kinds of recordings as the sections of one file, one with several ports."""
    folder = tmp_path_factory.mktemp("captures")
    path = folder / "all.pcapng"
    path.write_bytes(crafted() + vectors() + hostile(range(HOSTILE)) + sessions_of_program(folder))
    return path


@pytest.fixture(scope="module")
def capture(merged):
    return apart(merged)


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    path = tmp_path_factory.mktemp("captures") / "small.pcapng"
    path.write_bytes(crafted() + hostile(range(1000, 1030)))
    return apart(path)


def apart(path):
    """Return the capture with one port in each section."""
    separate = path.with_name(f"apart-{path.name}")
    with opened_capture(path) as file:
        separate.write_bytes(file.read())
    return separate


@pytest.fixture(scope="module")
def few(small, script):
    return shown(small, script)


@pytest.fixture(scope="module")
def packets(capture, script):
    return shown(capture, script)


@pytest.fixture(scope="module")
def twice(capture, script):
    return shown(capture, script, "-2")


@pytest.fixture(scope="module")
def parts(capture):
    return oracle.parts(capture)


def in_order(lines):
    return sorted(json.dumps(line, ensure_ascii=False) for line in lines)


def without_place(lines):
    return [{**line, "recording": 0, "port": ""} for line in lines]


def test_merged_ports_are_shown_as_if_each_were_alone(merged, script, twice):
    shown_merged = decoded(shown(merged, script, "-2"))
    assert in_order(without_place(shown_merged)) == in_order(without_place(decoded(twice)))


def test_one_pass_shows_every_frame_and_damage(capture, packets, parts):
    expected = [oracle.line(part) for part in oracle.without_ends(capture, parts)]
    for line, wanted in zip(decoded(packets), expected, strict=True):
        assert line == wanted


def test_two_passes_show_the_frames_in_which_a_recording_ends_too(twice, parts):
    assert in_order(decoded(twice)) == in_order(map(oracle.line, parts))


def test_the_second_pass_shows_what_the_first_one_showed(packets, twice):
    first, second = decoded(packets), decoded(twice)
    assert len(second) > len(first)
    rest = iter(second)
    assert all(line in rest for line in first)


def test_every_value_is_the_catalogs(capture, packets, parts):
    found = oracle.values(oracle.without_ends(capture, parts), shipped())
    items = [item for packet in packets for item in packet.items]
    assert sum(map(len, found)) > 1000
    for item, values in zip(items, found, strict=True):
        names = [name for name, _ in item if name.startswith("param.")]
        assert names == [f"param.{name}" for name, _ in values]
        texts = [text for name, text in item if name.startswith("param.")]
        for text, (_, value) in zip(texts, values, strict=True):
            assert text == f"{float(value):.15g}"


def test_requests_responses_and_echoes_refer_to_each_other(twice, packets, capture, parts):
    number_of, response_of = {}, {}
    counts: dict[tuple, int] = {}
    for packet in packets:
        for item in map(dict, packet.items):
            line = packet.recording, packet.port
            if item["direction"] == "sent" and item.get("damage") != "unfinished":
                counts[line] = serial = counts.get(line, -1) + 1
                number_of[*line, serial] = packet.number
    whole = oracle.without_ends(capture, parts)
    times = {packet.number: packet.time for packet in packets}
    shown_items = [(packet, dict(item)) for packet in packets for item in packet.items]
    answered = 0
    for (packet, item), part in zip(shown_items, whole, strict=True):
        serial = getattr(part, "answers", None) and part.answers.serial
        if serial is None or serial < 0:
            assert "request_in" not in item
            continue
        key = packet.recording, packet.port, serial
        assert int(item["request_in"]) == number_of[key]
        between = packet.time - times[number_of[key]]
        assert float(item["response_time"]) == pytest.approx(between, abs=1e-6)
        response_of.setdefault(number_of[key], packet.number)
        answered += 1
    assert answered > 500
    later = {packet.number: packet for packet in twice}
    for request, response in response_of.items():
        links = [dict(item).get("response_in") for item in later[request].items]
        assert str(response) in links
    for packet in packets:
        for item in map(dict, packet.items):
            if "echo" in item:
                sent = [dict(each) for each in later[int(item["echo_of"])].items]
                wires = [each.get("wire", each.get("damage.data")) for each in sent]
                assert item.get("wire", item.get("damage.data")) in wires


def test_two_adapters_of_one_name_are_two_lines(tmp_path, script):
    ports = (
        pcapng.Interface(name="/dev/ttyUSB0", description=each, speed=9600)
        for each in ("FT232", "CH340")
    )
    exchanges = [(OUTBOUND, b"\x61\x1a", 0), (OUTBOUND, b"\x61\x29", 1),
                 (INBOUND, b"\x15", 1), (INBOUND, b"\x7d", 0)]  # fmt: skip
    capture = tmp_path / "two.pcapng"
    packets = [
        pcapng.EnhancedPacket(port, 1_000_000 + at, encode(body), flags)
        for at, (flags, body, port) in enumerate(exchanges)
    ]
    capture.write_bytes(section(packets, *ports))
    found = decoded(shown(capture, script))
    expected = list(map(oracle.line, oracle.parts(capture)))
    assert in_order(without_place(found)) == in_order(without_place(expected))
    assert [line["meaning"] for line in found[2:]] == ["FREQ=840rpm", "TWAT=85°C"]


# As a user has it: installed, with filters, another language, a file that is cut off


def numbers(home, capture, *arguments):
    result = run(home, "-r", str(capture), "-T", "fields", "-e", "frame.number", *arguments)
    return [int(number) for number in result.stdout.split()]


@pytest.fixture
def installed(tmp_path):
    """A home folder with nothing but the plugin."""
    folder = tmp_path / "home/.local/lib/wireshark/plugins"
    folder.mkdir(parents=True)
    return plugin(folder / "mikas.lua").parents[4]


def test_installed_it_takes_recordings_without_any_setting(installed, small, few):
    assert numbers(installed, small, "-Y", "mikas") == [packet.number for packet in few]


def test_parameters_and_marks_are_fields_to_filter_by(installed, small, few):
    found = oracle.values(oracle.without_ends(small, oracle.parts(small)), shipped())
    items = [packet.number for packet in few for _ in packet.items]
    warm, idle = set(), set()
    for number, values in zip(items, found, strict=True):
        if any(name == "TWAT" and value > 85.5 for name, value in values):
            warm.add(number)
        if ("RXX", True) in values:
            idle.add(number)
    assert warm
    assert idle
    assert set(numbers(installed, small, "-Y", "mikas.param.TWAT > 85.5")) == warm
    assert set(numbers(installed, small, "-Y", "mikas.param.RXX == 1")) == idle
    echoes = {each.number for each in few for item in each.items if "echo" in dict(item)}
    assert set(numbers(installed, small, "-Y", "mikas.echo")) == echoes != set()


def test_every_filter_of_the_page_is_one(installed, small, few):
    english, russian = (
        re.findall(r"^\| `(mikas\.[^`]+)` \|", page.read_text("utf-8"), re.MULTILINE)
        for page in (ROOT / "docs/how-to/wireshark.md", ROOT / "docs/ru/how-to/wireshark.md")
    )
    assert english == russian
    assert "mikas.meaning" in english
    chosen = " or ".join(f"({each})" for each in english)
    meant = {each.number for each in few for item in each.items if "meaning" in dict(item)}
    assert set(numbers(installed, small, "-Y", chosen)) > meant


def test_the_results_of_writes_are_a_field(tmp_path, script):
    exchanges = [
        (flags, encode(body))
        for result in (b"\0", b"\1", b"\x0d")
        for flags, body in ((OUTBOUND, b"\x64\x1a"), (INBOUND, result))
    ]
    capture = tmp_path / "results.pcapng"
    capture.write_bytes(section([(*each, 1 + at / 10) for at, each in enumerate(exchanges)]))
    answers = [dict(packet.items[0]) for packet in shown(capture, script)][1::2]
    assert [answer["result"] for answer in answers] == ["0x00", "0x01", "0x0d"]


def test_a_read_filter_gives_the_number_of_a_refused_packet_to_the_next(installed, small, few):
    chosen = ("-2", "-R", "mikas.request", "-T", "fields", "-e", "mikas.meaning")
    lines = run(installed, "-r", str(small), *chosen).stdout.splitlines()
    expected = [
        [text for item in packet.items for name, text in item if name == "meaning"]
        for packet in few
        if any(name == "request" for item in packet.items for name, _ in item)
    ]
    assert lines == [",".join(texts) for texts in expected]


def test_damage_refusals_and_faults_are_expert_information(installed, small, few):
    printed = run(installed, "-r", str(small), "-q", "-z", "expert").stdout
    texts = [text.en for name, text in LABELS.items() if name.startswith("expert_")]
    for text in {*texts, "Bytes in the response", "The ECU refused"} - REPLACED:
        assert text in printed
    assert "Air mass signal low" in printed  # a stored fault
    names = [f"mikas.expert.{reason.replace(' ', '_')}" for reason in REASONS]
    chosen = [argument for name in ("frame.number", *names) for argument in ("-e", name)]
    rows = run(installed, "-r", str(small), "-T", "fields", *chosen).stdout.splitlines()
    for column, reason in enumerate(REASONS, 1):
        expected = {
            packet.number
            for packet in few
            for item in packet.items
            if dict(item).get("damage") == reason
        }
        cells = [row.split("\t") for row in rows]
        assert {int(cell[0]) for cell in cells if cell[column]} == expected != set()


@pytest.mark.parametrize("interpretation", ["literal", "alternative", "family"])
def test_a_script_in_russian_obeys_the_interpretation_of_the_setting(
    tmp_path, small, interpretation
):
    script = plugin(tmp_path / "mikas.lua", language="ru", interpretation="literal")
    found = shown(small, script, "-o", f"mikas.interpretation:{interpretation}")
    meanings = [dict(item).get("meaning") for packet in found for item in packet.items]
    expected = oracle.without_ends(small, oracle.parts(small, interpretation=interpretation))
    assert meanings == [getattr(part, "meaning", None) and part.meaning.ru for part in expected]


def test_the_users_own_parameter_is_a_field(tmp_path):
    own = tmp_path / "own.toml"
    own.write_text(
        '[parameter.BOOST]\ncode = 0x33\nsize = 2\nunit = "kPa"\nsigned = true\nscale = "1/8"\n'
        'text = { en = "Boost", ru = "Наддув" }\n',
        "utf-8",
    )
    capture = tmp_path / "boost.pcapng"
    capture.write_bytes(section([(2, encode(b"\x61\x33"), 1.0), (1, encode(b"\xfc\xff"), 1.1)]))
    script = plugin(tmp_path / "mikas.lua", load(own))
    _, response = shown(capture, script)
    assert dict(response.items[0])["param.BOOST"] == "-0.5"


def test_a_file_that_is_cut_off_shows_all_before_the_cut(tmp_path, small, script, few):
    cut = tmp_path / "cut.pcapng"
    cut.write_bytes(small.read_bytes()[:-7])
    found = shown(cut, script, check=False)
    assert len(found) == len(few) - 1
    assert decoded(found) == decoded(few[:-1])
