"""`mikas split`, and what the other commands say of a file of several cars."""

from __future__ import annotations

import gzip
import json

import pytest

import mikas as library
from merged_harness import record


@pytest.fixture
def joined(tmp_path):
    one = record(tmp_path / "one.pcapng", "A111AA52", version=9, port="/dev/ttyUSB0")
    two = record(tmp_path / "two.pcapng", "B222BB52", faults="53", port="/dev/ttyUSB1")
    path = tmp_path / "both.pcapng"
    path.write_bytes(one.read_bytes() + two.read_bytes())
    return path


def test_a_file_of_each_car_is_made(mikas, joined):
    (joined.parent / "both-1.pcapng").write_text("another file")
    ran = mikas("split", joined.name)
    assert ran.status == 0, ran.err
    assert ran.out == "both-2.pcapng: A111AA52\nboth-3.pcapng: B222BB52\n"
    for number, name in ((2, "one"), (3, "two")):
        part = joined.with_name(f"both-{number}.pcapng")
        assert part.read_bytes() == joined.with_name(f"{name}.pcapng").read_bytes()
        assert library.open(part).row_count
    assert (joined.parent / "both-1.pcapng").read_text() == "another file"


def test_the_parts_of_a_packed_file_have_its_plain_name(mikas, joined):
    joined.with_name("both.pcapng.gz").write_bytes(gzip.compress(joined.read_bytes()))
    ran = mikas("split", "both.pcapng.gz")
    assert ran.out == "both-1.pcapng: A111AA52\nboth-2.pcapng: B222BB52\n"


def test_a_file_of_one_car_is_left_alone(mikas, joined):
    ran = mikas("split", "one.pcapng")
    assert ran.status == 0
    assert "nothing to split" in ran.err
    assert not list(joined.parent.glob("one-*"))


@pytest.mark.parametrize(
    "command",
    [
        ("export", "both.pcapng", "-o", "out.csv"),
        ("find", "both.pcapng", "FREQ > 1"),
        ("--port", "replay:both.pcapng", "read", "FREQ"),
    ],
)
def test_a_command_that_would_mix_them_names_both_and_the_way(mikas, joined, command):
    ran = mikas(*command)
    assert ran.status
    assert "1: A111AA52, 2: B222BB52" in ran.err
    assert "mikas split" in ran.err
    assert not joined.with_name("out.csv").exists()


def test_a_report_is_of_one_car_and_names_all(mikas, joined):
    ran = mikas("report", "both.pcapng", "-o", "out.html", "--json")
    assert ran.status == 0, ran.err
    assert json.loads(ran.out)["faults"] == [53]
    assert "1: A111AA52, 2: B222BB52" in ran.err
    page = joined.with_name("out.html").read_text("utf-8")
    assert "recordings of 2 cars (A111AA52, B222BB52)" in page
    assert "Mikas 7.1" in page
    assert "Mikas 5.4" not in page


def test_decode_shows_where_another_recording_begins(mikas, joined):
    lines = mikas("decode", "both.pcapng").out.splitlines()
    assert [line for line in lines if "recording" in line] == ["recording 2: /dev/ttyUSB1"]
