"""Instruments beside the unit in Wireshark: named, line by line, and the unit as without them.

Skipped where there is no tshark, unless `MIKAS_REQUIRE_TSHARK` is set: then that is a failure.
"""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

from dissectors.tshark_harness import TSHARK, run, shown
from instrument_recording import record
from mikas.catalog import shipped
from mikas.dissectors.wireshark.generator import source
from mikas.i18n import Text
from mikas.recording.capture.instruments import CONNECTED, loss

pytestmark = pytest.mark.skipif(
    shutil.which(TSHARK) is None and not os.environ.get("MIKAS_REQUIRE_TSHARK"),
    reason="tshark is not installed",
)
LC1 = bytes.fromhex("B2 82 43 13 03 6B")
SAID = [
    (0, [(0, b"", 0.0, CONNECTED), (1, b"", 0.0, CONNECTED)]),
    (1, [(0, b"\r\n14.", 0.0, ""), (1, LC1, 0.0, "")]),
    (2, [(0, b"7\r\n0.98\r\n", 0.0, "")]),
    (3, [(0, b"1", 0.0, ""), (0, b"", 0.001, loss(Text("unplugged", "отключён")))]),
    (4, [(0, b"", 0.0, CONNECTED), (0, b"3.0\r\n", 0.001, ""), (0, b"\xff\r\n", 0.002, "")]),
]


def lines(path: Path, script: Path, *more: str) -> list[list[str]]:
    fields = ("_ws.col.Source", "_ws.col.Info", "mikas_instrument.line")
    chosen = [word for name in fields for word in ("-e", name)]
    arguments = ("-X", f"lua_script:{script}", "-r", str(path), "-Y", "mikas_instrument", *more)
    found = run(script.parent, *arguments, "-T", "fields", *chosen)
    assert "Lua" not in found.stderr, found.stderr
    return [line.split("\t") for line in found.stdout.splitlines()]


@pytest.mark.parametrize("passes", [(), ("-2",)])
def test_each_is_named_and_a_line_in_two_pieces_is_one(
    tmp_path: Path, passes: tuple[str, ...]
) -> None:
    script = tmp_path / "mikas.lua"
    script.write_text(source(shipped(), "en", "corrected", "0"), "utf-8")
    path = record(tmp_path / "a.pcapng", SAID, (("aem", "left"), ("innovate", "")), count=6)
    assert lines(path, script, *passes) == [
        ["left:aem", "instrument left:aem: connected", ""],
        ["innovate", "instrument innovate: connected", ""],
        ["left:aem", "instrument left:aem: goes on in the next packet", ""],
        ["innovate", "instrument innovate: B2 82 43 13 03 6B", ""],
        ["left:aem", "instrument left:aem: 14.7 | 0.98", "14.7,0.98"],
        ["left:aem", "instrument left:aem: goes on in the next packet", ""],
        ["left:aem", "instrument left:aem: lost", ""],
        ["left:aem", "instrument left:aem: connected", ""],
        ["left:aem", "instrument left:aem: 3.0", "3.0"],
        ["left:aem", "instrument left:aem: FF 0D 0A", ""],
    ]


def test_the_units_frames_are_those_of_a_recording_without_instruments(tmp_path: Path) -> None:
    script = tmp_path / "mikas.lua"
    script.write_text(source(shipped(), "ru", "corrected", "0"), "utf-8")
    both = record(tmp_path / "a.pcapng", SAID, (("aem", "left"), ("innovate", "")), count=6)
    alone = record(tmp_path / "b.pcapng", definitions=(), count=6)
    items = [
        [packet.items for packet in shown(path, script) if packet.items] for path in (both, alone)
    ]

    def values(found: list[list[list[tuple[str, str]]]]) -> list[str]:
        return [
            value
            for packet in found
            for item in packet
            for name, value in item
            if name == "meaning"
        ]

    assert values(items[0]) == values(items[1])
    assert len(values(items[0])) > 10
    assert lines(both, script)[0][1] == "прибор left:aem: connected"
