"""How fast the bulk decoder is: frames against numpy's own copy, captures against real time.

Frames: 25-byte responses as `batch` brings them, stuffed as random data need, in pieces that stay
in the processor's cache, on one core; and in the same run numpy copies the same bytes. They are
more than the caches hold, as a 10-hour capture is, for a copy within them measures the cache.

Tables: an hour on the wire at §5's rates, one packet a request, an echo, a response, made by
repeating packets of a session with a virtual unit at shifted times.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from random import Random
from statistics import median
from time import perf_counter

import numpy as np

from mikas.catalog import shipped
from mikas.framing import encode
from mikas.link.tee import Direction
from mikas.recording import pcapng
from mikas.recording.bulk import BulkDecoder, TableReader
from mikas.recording.reader import FLAGS

PIECE = 1 << 18
_RUNS = 7


def run(*, quick: bool = False) -> None:
    frames(megabytes=16 if quick else 64)
    print(f"Tables of a synthetic capture, {'6 minutes' if quick else 'an hour'}, all 21 codes:\n")
    print("| method | packets | file | read | rows | times real time |")
    print("|---|---|---|---|---|---|")
    for method in ("batch", "list", "stream"):
        table(method, seconds=360 if quick else 3600)
    print()


def frames(megabytes: int) -> None:
    random = Random(1)
    pattern = b"".join(encode(random.randbytes(25)) for _ in range(20_000))
    wire = np.frombuffer(pattern * (megabytes * 1_000_000 // len(pattern)), np.uint8)
    target = np.empty_like(wire)
    target[:] = 0  # the pages are there before the first copy
    copies, decodes = [], []
    for _ in range(_RUNS):
        began = perf_counter()
        np.copyto(target, wire)
        copies.append(perf_counter() - began)
        began = perf_counter()
        decoder = BulkDecoder()
        for at in range(0, wire.size, PIECE):
            decoder.feed(wire[at : at + PIECE])
        decodes.append(perf_counter() - began)
    copy, decode = median(copies), median(decodes)
    print(
        f"Bulk decoder, {wire.size / 1e6:.0f} MB of 25-byte responses, median of {_RUNS}: "
        f"{wire.size / decode / 1e6:.0f} MB/s, {100 * copy / decode:.1f} % of numpy's own copy "
        f"({wire.size / copy / 1e9:.1f} GB/s).\n"
    )


def table(method: str, seconds: float) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "hour.pcapng"
        packets = synthetic(path, method, seconds)
        began = perf_counter()
        rows = sum(len(stretch.times) for stretch in TableReader(path, shipped()).rows())
        took = perf_counter() - began
        size = path.stat().st_size / 1e6
    print(
        f"| {method} | {packets:,} | {size:.1f} MB | {took:.2f} s | {rows:,} | "
        f"{seconds / took:,.0f} |"
    )


def synthetic(path: Path, method: str, seconds: float) -> int:
    """A capture of so many seconds; returns its packets."""
    codes = bytes(code for code, _ in shipped().codes)
    size = sum(size for _, size in shipped().codes)
    random = Random(2)
    start, again = {
        "batch": ([], b"\x61" + codes),
        "list": ([(b"\x64" + codes, b"\x00")], b"\x63"),
        "stream": ([(b"\x71" + codes, None)], None),
    }[method]
    clock = _Clock()
    count = 0
    with path.open("wb") as file:
        file.write(pcapng.encode(pcapng.Section()) + pcapng.encode(pcapng.Interface(speed=9600)))
        for request, answer in [(b"\x01", b"\x0a"), *start]:
            blocks = clock.exchange(request, answer)
            count += len(blocks)
            file.write(b"".join(pcapng.encode(block) for block in blocks))
        # A thousand different sets again and again; only their times differ.
        began = clock.now
        blocks = [b for _ in range(1000) for b in clock.exchange(again, random.randbytes(size))]
        period = round((clock.now - began) * 1e6)
        encoded = [pcapng.encode(block) for block in blocks]
        edges = np.cumsum([0, *map(len, encoded)])
        words = np.frombuffer(b"".join(encoded), "<u4").copy()
        low = edges[:-1] // 4 + 4  # the word with a block's ticks
        ticks = np.array([block.ticks for block in blocks])
        for lap in range(round(seconds * 1e6) // period):
            words[low - 1], words[low] = np.divmod(ticks + lap * period, 1 << 32)
            file.write(words.tobytes())
            count += len(blocks)
    return count


class _Clock:
    """Exchanges one behind another on a line that echoes, d = 2 ms."""

    def __init__(self) -> None:
        self.now = 0.0

    def exchange(self, request: bytes | None, answer: bytes | None) -> list[pcapng.EnhancedPacket]:
        blocks = []
        if request is not None:
            wire = encode(request)
            blocks.append(self._packet(Direction.SENT, wire))
            self.now += len(wire) / 960
            blocks.append(self._packet(Direction.RECEIVED, wire))
            self.now += 0.002
        if answer is not None:
            wire = encode(answer)
            self.now += len(wire) / 960
            blocks.append(self._packet(Direction.RECEIVED, wire))
        return blocks

    def _packet(self, direction: Direction, data: bytes) -> pcapng.EnhancedPacket:
        return pcapng.EnhancedPacket(0, round(self.now * 1e6), data, FLAGS[direction])
