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
from dissectors.sessions_harness import (
    INBOUND,
    OUTBOUND,
    crafted,
    hostile,
    section,
    sessions_of_program,
    vectors,
)
from mikas.catalog import shipped
from mikas.dissectors.wireshark.generator import in_ascii, source
from mikas.framing import encode
from mikas.link.base import Direction
from mikas.recording.capture.reader import CaptureReader, Packet
from mikas.recording.exchanges.scalar import DecodedFrame
from mikas.recording.exchanges.verdicts import Doubt

LUA = "lua5.4"
HOSTILE = 120 if os.environ.get("HYPOTHESIS_PROFILE") == "ci" else 40  # lines
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


def digits(data):
    return data.hex(" ").upper()


def said(part):
    role = "echo" if part.echo else ""
    if isinstance(part, DecodedFrame):
        if part.doubt:
            role = part.doubt.value.en
        elif part.request is not None:
            role = digits(part.request)
        meaning = part.meaning.en if part.meaning else ""
        return f"{digits(part.frame.body)}\t{meaning}\t{role}"
    return f"{part.reason}\t{digits(part.data)}\t\t{role}"


def run(script, *arguments, packets=""):
    """Return the lines that `bare_lua.lua` prints."""
    result = subprocess.run(
        [LUA, str(READER), str(script), *arguments],
        input=packets,
        capture_output=True,
        encoding="utf-8",
        check=False,
    )
    assert result.returncode == 0, result.stderr
    return result.stdout.splitlines()


def test_it_says_what_mikas_decode_says(tmp_path):
    capture, script = tmp_path / "all.pcapng", tmp_path / "mikas.lua"
    recorded = crafted() + vectors() + hostile(range(HOSTILE)) + sessions_of_program(tmp_path)
    capture.write_bytes(recorded)
    script.write_text(in_ascii(source(shipped(), "en", "corrected", "0")), "ascii")
    found = run(script, packets="".join(f"{line}\n" for line in lines_of(capture)))
    parts = oracle.without_ends(capture, oracle.parts(capture))
    assert found == [said(part) for part in parts]
    assert {part.doubt for part in parts if isinstance(part, DecodedFrame)} == {None, *Doubt}


@pytest.mark.parametrize(
    ("kind", "packets"),
    [
        ("many in a packet", [(OUTBOUND, b"\0\r" * 5000), (INBOUND, b"\0\r" * 5000)] * 10),
        ("alone", [(OUTBOUND, b"\0\r"), (INBOUND, b"\1\r")] * 10_000),
        ("answered", [(OUTBOUND, encode(b"\x61\x1a")), (INBOUND, encode(b"\x7d"))] * 10_000),
    ],
)
def test_memory_is_a_small_multiple_of_the_file(tmp_path, kind, packets):
    """Two-byte frames took a thousand times their size."""
    capture, script = tmp_path / "all.pcapng", tmp_path / "mikas.lua"
    script.write_text(source(shipped(), "en", "corrected", "0"), "utf-8")
    timed = [(flags, data, 1 + at / 10) for at, (flags, data) in enumerate(packets)]
    capture.write_bytes(section(timed))
    (empty,) = run(script, "memory")
    (full,) = run(script, "memory", packets="".join(f"{line}\n" for line in lines_of(capture)))
    assert int(full) - int(empty) < 4 * capture.stat().st_size, kind


def test_a_field_has_the_unit_and_errata_of_the_interpretation_it_was_made_with(tmp_path):
    script = tmp_path / "mikas.lua"
    for interpretation, unit in (("corrected", "rpm"), ("literal", "1/s")):
        script.write_text(source(shipped(), "en", interpretation, "0"), "utf-8")
        rows = [line.split("\t") for line in run(script, "fields")]
        ((name, about),) = (row[1:] for row in rows if row[0] == "mikas.param.FREQ")
        assert name == f"Crankshaft speed, {unit}"
        assert about.startswith(f"{name}. E1: ")
        assert ("rpm" in about) == (unit == "rpm")
