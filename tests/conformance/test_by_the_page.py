"""docs/protocol.md alone is enough for a tester: `by_the_page` works on every kind of unit."""

from __future__ import annotations

import ast
from contextlib import suppress
from pathlib import Path

import pytest
from by_the_page import Refused, Void
from by_the_page import Tester as ByThePage

from mikas.link import open_link

UNITS = [
    "", "echo=0", "model=5.4", "raw_checksum=1", "counted_blocks=1", "unknown=01",
    "stream_end=request", "stream_end=break", "turn_round=0.1", "stream_gap=0.005", "latency_ms=16",
]  # fmt: skip


class Line:
    """A link of mikas as the page's tester needs it."""

    def __init__(self, link):
        self.link = link
        self.write, self.now, self.send_break = link.write, link.now, link.send_break

    def read(self, deadline):
        return self.link.read(deadline).data


@pytest.fixture
def tester_of():
    links = []

    def connected(options):
        options = "&".join(filter(None, ["clock=simulated", "seed=1", "faults=41+64", options]))
        links.append(open_link(f"sim:?{options}"))
        return ByThePage(Line(links[-1]))

    yield connected
    for link in links:
        link.close()


@pytest.mark.parametrize("options", UNITS)
def test_it_reads_writes_erases_and_streams(tester_of, options):
    tester = tester_of(options)
    assert tester.connect() == (0x09 if "5.4" in options else 0x0A)
    assert tester.echo == (options != "echo=0")
    (coolant,), (speed,), injection = tester.read(0x1A, 0x29, 0x3F)
    assert 20 < coolant - 40 < 120
    assert 500 < speed * 40 < 1500
    assert 1 < int.from_bytes(injection, "little") / 125 < 10
    assert tester.ask([0x64, 0x1A, 0x3F], 1) == b"\x00"
    assert tester.ask([0x63], 3)[0] == pytest.approx(coolant, abs=2)
    assert tester.ask([0x12, 0x40, 0x0D], 2) == b"\x40\x0d"
    assert tester.ask([0x11, 0x40], 2) == b"\x40\x0d"
    assert tester.ask([0x24, 0x0D, 0x40, 3, 0x0D, 0x40, 0xC0], 1) == b"\x00"
    assert tester.read_bytes(0x23, 0x400D, 3) == b"\x0d\x40\xc0"
    assert len(tester.read_bytes(0x25, 0x0000, 255)) == 255
    assert len(tester.ask([0x51], 16)) == 16
    assert tester.faults() == [41, 64]
    tester.erase()
    assert tester.faults() == []
    with pytest.raises(Refused):
        tester.ask([0x99], 2)
    rows = tester.stream(0x71, 0x1A, 0x3F, count=20)
    assert all([len(datum) for datum in row] == [1, 2] for row in rows)
    assert len(tester.stream(0x80, 0x29, count=3)) == 3
    assert 500 < tester.read(0x29)[0][0] * 40 < 1500


def test_a_noisy_line_never_gives_it_a_wrong_value(tester_of):
    tester = tester_of("damaged=0.03&late=0.03&lost=0.03&noise=0.03&cut=0.03&doubled=0.03")
    for _ in range(5):  # the first exchange is disturbed as any other
        with suppress(Void):
            tester.connect()
            break
        tester.quiet(1)
    values = []
    for _ in range(200):
        with suppress(Refused):
            values.append(tester.read(0x1A)[0][0])
    assert len(values) > 150
    assert max(values) - min(values) <= 3


def test_it_knows_nothing_of_mikas():
    tree = ast.parse((Path(__file__).parent / "by_the_page.py").read_text("utf-8"))
    imports = [each for each in ast.walk(tree) if isinstance(each, ast.Import | ast.ImportFrom)]
    assert [each.module for each in imports] == ["__future__"]
