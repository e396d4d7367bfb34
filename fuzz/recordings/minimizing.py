"""A finding's file made small: without the blocks, then without the bytes that it does not need."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from time import monotonic
from typing import Final, TypeVar

from fuzz.recordings.mutations import pieces

T = TypeVar("T")

_SECONDS: Final = 20.0


def minimized(data: bytes, fails: Callable[[bytes], bool]) -> bytes:
    """Return a part of `data` of which `fails` is true as well; after some seconds the best one."""
    until = monotonic() + _SECONDS
    kept = _without(pieces(data), lambda parts: fails(b"".join(parts)), until)
    data = b"".join(kept)
    if len(data) > 2000:
        return data
    return bytes(_without(list(data), lambda some: fails(bytes(some)), until))


def _without(parts: Sequence[T], fails: Callable[[Sequence[T]], bool], until: float) -> list[T]:
    """Drop halves, quarters … single parts, as long as it still fails."""
    kept, size = list(parts), max(1, len(parts) // 2)
    while monotonic() < until:
        at = 0
        while at < len(kept) and monotonic() < until:
            fewer = kept[:at] + kept[at + size :]
            if fewer and fails(fewer):
                kept = fewer
            else:
                at += size
        if size == 1:
            break
        size //= 2
    return kept
