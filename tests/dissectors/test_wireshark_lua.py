"""The dissector's rules in Lua 5.4, which Wireshark has from 4.4 on: there an integer is no float.

`test_wireshark_tshark.py` runs it in the Wireshark that is installed, whose Lua may be 5.2. Skipped
where there is no lua5.4, unless `MIKAS_REQUIRE_LUA` is set: then that is a failure.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from dissectors import oracle_harness as oracle
from dissectors.sessions_harness import crafted, hostile, sessions_of_program, vectors
from mikas.catalog import shipped
from mikas.dissectors.wireshark import in_ascii, source
from mikas.link.base import Direction
from mikas.recording.capture.reader import CaptureReader, Packet
from mikas.recording.exchanges.scalar import DecodedFrame

LUA = "lua5.4"
READER = Path(__file__).parent / "bare_lua.lua"

pytestmark = pytest.mark.skipif(
    shutil.which(LUA) is None and not os.environ.get("MIKAS_REQUIRE_LUA"),
    reason="lua5.4 is not installed",
)


def lines_of(capture):
    """Return the packets as `bare_lua.lua` reads them."""
    for item in CaptureReader(capture):
        if not isinstance(item, Packet):
            yield "!"
            continue
        port = f"{item.source.recording}/{item.source.url}"
        way = 1 if item.direction is Direction.SENT else 2
        yield f"{port} {way} {item.time!r} {item.data.hex()}"


def said(part):
    if isinstance(part, DecodedFrame):
        meaning = part.meaning.en if part.meaning else ""
        return f"{part.frame.body.hex(' ').upper()}\t{meaning}"
    return f"{part.reason}\t{part.data.hex(' ').upper()}"


def test_it_says_what_mikas_decode_says(tmp_path):
    capture, script = tmp_path / "all.pcapng", tmp_path / "mikas.lua"
    capture.write_bytes(crafted() + vectors() + hostile(range(16)) + sessions_of_program(tmp_path))
    script.write_text(in_ascii(source(shipped(), "en", "corrected", "0")), "ascii")
    result = subprocess.run(
        [LUA, str(READER), str(script)],
        input="".join(f"{line}\n" for line in lines_of(capture)),
        capture_output=True,
        encoding="utf-8",
        check=False,
    )
    assert result.returncode == 0, result.stderr
    expected = [said(part) for part in oracle.without_ends(capture, oracle.parts(capture))]
    assert len(expected) > 1000
    assert result.stdout.splitlines() == expected
