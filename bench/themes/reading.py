"""How fast a long recording is opened, exported and replayed; the bulk decoder behind that."""

from __future__ import annotations

import io
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from random import Random

import numpy as np

import mikas
from bench.recorded import recorded
from bench.rows import Row, Scope, Theme, timed
from mikas.framing import Decoder, encode
from mikas.recording.exchanges.columns.frames import BulkDecoder
from mikas.replay import load

PIECE = 1 << 18
_SUFFIXES = ("parquet", "csv", "mf4")

_RECORDING = """\
A recording of {hours} hour(s) as `mikas log` writes it, all codes by list, {megabytes:.0f} MB: a
session with a virtual unit that drives in a city, five minutes of it repeated at shifted times,
with a marker each lap and a gap each hour. It has just been written, so it is in the system's file
cache. Exports are `mikas export` as a whole process, with all derived channels."""

_DECODERS = """\
Frames of 25 data bytes, as `batch` brings them, stuffed as random data need; one core, {runs} runs.
The bulk decoder gets {megabytes} MB in pieces of 256 KiB, which stay in the processor's cache, and
in the same run numpy copies the same bytes, more than the caches hold: their ratio counts."""


def run(scope: Scope) -> Iterator[Theme]:
    yield recordings(scope)
    yield decoders(scope)


def recordings(scope: Scope) -> Theme:
    hours, runs = scope.of(10, 1), scope.of(5, 1)
    wire = hours * 3600.0
    with tempfile.TemporaryDirectory() as folder:
        path = recorded(Path(folder) / "drive.pcapng", hours, lap=300 if hours > 1 else 60)
        size = path.stat().st_size / 1e6
        opened = timed(lambda: mikas.open(path), runs)
        how = "`mikas.open`, which looks through the file for its channels and damage."
        limit = None if scope.quick else 2.0
        rows = [Row(f"open {hours} hour(s)", opened, "s", 2, at_most=limit, how=how)]
        for suffix in _SUFFIXES:
            seconds = _exported(path, suffix, runs if suffix == "parquet" else 1)
            rows.append(
                Row(
                    f"export to .{suffix}",
                    [wire / each for each in seconds],
                    "× real time",
                    0,
                    at_least=3000 if suffix == "parquet" and not scope.quick else None,
                    aside=f"{sorted(seconds)[len(seconds) // 2]:.1f} s",
                )
            )
        part = recorded(Path(folder) / "part.pcapng", 1, lap=60)
        seconds = timed(lambda: load(part), 1)
        how = "an hour; what `sim --replay` and `replay:` do before they answer; once."
        rates = [3600 / each for each in seconds]
        aside = f"{seconds[0]:.1f} s"
        rows.append(Row("load for replay", rates, "× real time", 0, aside=aside, how=how))
        rows += _in_a_notebook(part, runs, scope)
    method = _RECORDING.format(hours=hours, megabytes=size)
    return Theme("Recordings", method, rows)


def _in_a_notebook(part: Path, runs: int, scope: Scope) -> Iterator[Row]:
    """Yield how long an hour takes to show itself and to be drawn, each for the first time."""
    import matplotlib as mpl
    from matplotlib import pyplot as plt

    mpl.use("Agg")

    def draw() -> None:
        mikas.open(part).plot().figure.savefig(io.BytesIO(), format="png")
        plt.close("all")

    mikas.open(part)._repr_html_()
    draw()
    limit = None if scope.quick else 2.0
    shown = timed(lambda: mikas.open(part)._repr_html_(), runs)
    how = "an hour: `mikas.open` and what a notebook shows of it."
    yield Row("show in a notebook", shown, "s", 2, at_most=limit, how=how)
    how = "an hour: `mikas.open` and `plot()`, until the picture is a PNG."
    yield Row("plot", timed(draw, runs), "s", 2, at_most=limit, how=how)


def _exported(path: Path, suffix: str, runs: int) -> list[float]:
    out = path.with_suffix(f".{suffix}")
    command = [sys.executable, "-m", "mikas", "export", str(path), "-o", str(out), "--overwrite"]
    taken = timed(lambda: subprocess.run(command, check=True, capture_output=True), runs)
    out.unlink()
    return taken


def decoders(scope: Scope) -> Theme:
    runs, megabytes = scope.of(7, 3), scope.of(64, 16)
    random = Random(1)
    pattern = b"".join(encode(random.randbytes(25)) for _ in range(20_000))
    wire = np.frombuffer(pattern * (megabytes * 1_000_000 // len(pattern)), np.uint8)
    target = np.empty_like(wire)
    target[:] = 0  # the pages are there before the first copy
    shares, speeds, copies = [], [], []
    for _ in range(runs):
        (copy,) = timed(lambda: np.copyto(target, wire), 1)
        (decode,) = timed(lambda: _bulk(wire), 1)
        shares.append(100 * copy / decode)
        speeds.append(wire.size / decode / 1e6)
        copies.append(wire.size / copy / 1e9)
    aside = f"{np.median(speeds):,.0f} MB/s; the copy {np.median(copies):.1f} GB/s"
    rows = [Row("bulk decoder", shares, "% of a copy", 1, at_least=2.5, aside=aside)]
    part = pattern[: scope.of(1_000_000, 200_000)]
    for name, piece in (("whole", len(part)), ("byte by byte", 1)):
        chunks = [part[at : at + piece] for at in range(0, len(part), piece)]
        rates = [len(part) / each / 1e6 for each in timed(partial(_fed, chunks), runs)]
        aside = f"{sorted(rates)[len(rates) // 2] * 1e6 / 960:,.0f} times the wire"
        rows.append(Row(f"incremental decoder, fed {name}", rates, "MB/s", 2, aside=aside))
    return Theme("Decoders", _DECODERS.format(runs=runs, megabytes=megabytes), rows)


def _bulk(wire: np.ndarray) -> None:
    decoder = BulkDecoder()
    for at in range(0, wire.size, PIECE):
        decoder.feed(wire[at : at + PIECE])


def _fed(chunks: list[bytes]) -> None:
    decoder = Decoder()
    for chunk in chunks:
        decoder.feed(chunk)
