"""How fast a long recording is in Wireshark with the plugin: tshark, Wireshark's own engine."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from bench.recorded import recorded
from bench.rows import Row, Scope, Theme, timed
from mikas.catalog import shipped
from mikas.dissectors.wireshark.generator import source
from mikas.recording.capture.reader import CaptureReader, Packet

_HOURS = 0.29  # some 100,000 packets
_FILTER = "mikas.param.TWAT > 90"

_METHOD = """\
A recording of {minutes:.0f} minutes, all codes by list, {packets:,} packets, {megabytes:.1f} MB,
read by {version} as a whole process, in one pass. Wireshark's window reads it as the first row
does, and again for each new filter."""


def run(scope: Scope) -> Iterator[Theme]:
    if shutil.which("tshark") is None:
        raise SystemExit("bench dissectors: tshark is not installed")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        hours = _HOURS if not scope.quick else 0.02
        path = recorded(folder / "drive.pcapng", hours, lap=60)
        plugin = folder / "mikas.lua"
        plugin.write_text(source(shipped(), "en", "corrected", "bench"), "utf-8")
        yield _wireshark(path, plugin, scope.of(3, 1), hours)


def _wireshark(path: Path, plugin: Path, runs: int, hours: float) -> Theme:
    packets = sum(isinstance(item, Packet) for item in CaptureReader(path))
    home = {**os.environ, "HOME": str(path.parent), "TZ": "UTC"}
    reads = ("tshark", "-r", str(path))
    with_plugin = (*reads, "-X", f"lua_script:{plugin}")
    filtered = (*with_plugin, "-Y", _FILTER)
    fields = (*with_plugin, "-T", "fields", "-e", "mikas.param.TWAT", "-e", "mikas.param.FREQ")
    decode = (sys.executable, "-m", "mikas", "decode", "--json", str(path))
    version = subprocess.run(("tshark", "--version"), capture_output=True, text=True, check=True)
    method = _METHOD.format(
        minutes=hours * 60,
        packets=packets,
        megabytes=path.stat().st_size / 1e6,
        version=version.stdout.partition(" (Git")[0].partition("\n")[0],
    )
    rows = [
        _row("opened", (*with_plugin, "-q"), runs, home, packets),
        _row(f"filtered by `{_FILTER}`", filtered, runs, home, packets),
        _row("two columns of values", fields, runs, home, packets),
        _row("JSON of everything", (*with_plugin, "-T", "json"), 1, home, packets),
        _row("`mikas decode --json` beside it", decode, 1, home, packets),
        _row("opened without the plugin", (*reads, "-q"), runs, home, packets),
    ]
    return Theme("Recordings in Wireshark", method, rows)


def _row(what: str, command: Sequence[str], runs: int, home: dict[str, str], packets: int) -> Row:
    measured = timed(lambda: _run(command, home), runs)
    rate = packets / sorted(measured)[len(measured) // 2]
    return Row(what, measured, "s", aside=f"{rate:,.0f} packets/s")


def _run(command: Sequence[str], environment: dict[str, str]) -> None:
    subprocess.run(
        command,
        check=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env=environment,
    )
