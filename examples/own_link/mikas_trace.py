"""A link of your own: `trace:URL` opens any other port and prints every byte on stderr."""

from __future__ import annotations

import sys

from mikas.link import Chunk, Link, open_link


class TraceLink(Link):
    """Another link, with its bytes printed. The contract of a link: `mikas.link.base`."""

    def __init__(self, url: str, inner: Link) -> None:
        self.url, self.baud, self._inner = url, inner.baud, inner

    @property
    def granularity(self) -> float:
        return self._inner.granularity

    def write(self, data: bytes) -> None:
        print(f"{self.now():.4f} > {data.hex(' ')}", file=sys.stderr)
        self._inner.write(data)

    def read(self, deadline: float) -> Chunk:
        chunk = self._inner.read(deadline)
        if chunk.data:
            print(f"{chunk.time:.4f} < {chunk.data.hex(' ')}", file=sys.stderr)
        return chunk

    def now(self) -> float:
        return self._inner.now()

    def send_break(self, seconds: float) -> None:
        self._inner.send_break(seconds)

    def close(self) -> None:
        self._inner.close()


def open_trace(url: str, options: dict[str, str]) -> Link:
    """Open `trace:URL`; the options belong to the inner URL."""
    return TraceLink(url, open_link(url.partition(":")[2]))
