"""How a unit can be asked for its parameters again and again (§3 rows 61, 63, 71, 7F–83)."""

from __future__ import annotations

from typing import Literal, get_args

FixedMethod = Literal[
    "single", "batch", "list", "stream", "stroke0", "stroke1", "stroke2", "stroke3", "stroke4"
]
Method = Literal["auto", FixedMethod]

FIXED_METHODS: tuple[FixedMethod, ...] = get_args(FixedMethod)
METHODS: tuple[Method, ...] = get_args(Method)
STREAMS = frozenset({"stream", *(m for m in FIXED_METHODS if m.startswith("stroke"))})


def stroke_of(method: str) -> int | None:
    """The stroke of `stroke0` … `stroke4`; None for the cyclic stream."""
    return int(method[-1]) if method.startswith("stroke") else None
