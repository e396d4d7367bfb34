"""How fast the incremental decoder is, fed whole and byte by byte (§2)."""

from __future__ import annotations

from random import Random
from statistics import median
from time import perf_counter

from mikas.framing import Decoder, encode

_RUNS = 5


def run() -> None:
    random = Random(1)
    # Responses as `batch` brings them: 25 data bytes, stuffed as random data need.
    wire = b"".join(encode(random.randbytes(25)) for _ in range(40_000))
    rates = {}
    for name, piece in (("whole", len(wire)), ("byte by byte", 1)):
        chunks = [wire[at : at + piece] for at in range(0, len(wire), piece)]
        rates[name] = len(wire) / 1e6 / median(_seconds(chunks) for _ in range(_RUNS))
    print(f"Decoder, {len(wire) / 1e6:.1f} MB of 25-byte responses, median of {_RUNS}:")
    for name, rate in rates.items():
        print(f"- {name}: {rate:.2f} MB/s ({rate * 1e6 / 960:,.0f} times the wire)")
    print()


def _seconds(chunks: list[bytes]) -> float:
    decoder = Decoder()
    began = perf_counter()
    for chunk in chunks:
        decoder.feed(chunk)
    return perf_counter() - began
