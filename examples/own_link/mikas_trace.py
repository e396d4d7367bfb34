"""A link of your own: `trace:URL` opens any other port and prints every byte on stderr."""

from __future__ import annotations

import sys

from mikas.link import Chunk, Link, LinkWrapper, open_link


class TraceLink(LinkWrapper):
    """Another link, with its bytes printed. The contract of a link: `mikas.link.base.Link`."""

    def __init__(self, url: str, inner: Link) -> None:
        super().__init__(inner)
        self.url = url

    def write(self, data: bytes) -> None:
        print(f"{self.now():.4f} > {data.hex(' ')}", file=sys.stderr)
        self.link.write(data)

    def read(self, deadline: float) -> Chunk:
        chunk = self.link.read(deadline)
        if chunk.data:
            print(f"{chunk.time:.4f} < {chunk.data.hex(' ')}", file=sys.stderr)
        return chunk


def open_trace(url: str, options: dict[str, str]) -> Link:
    """Open `trace:URL`; the options belong to the inner URL."""
    return TraceLink(url, open_link(url.partition(":")[2]))
