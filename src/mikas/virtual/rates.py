"""What a receiver of one baud rate makes of a byte that was sent at another one."""

from __future__ import annotations

from functools import lru_cache

_BITS = 10  # start bit, eight data bits, stop bit


@lru_cache(maxsize=1 << 12)
def seen(value: int, sent: int, heard: int) -> tuple[int, ...]:
    """Return the bytes that a UART of `heard` baud receives when `value` is sent at `sent` baud.

    It samples the middle of each of its bits, from a falling edge on; the line is high before and
    after the byte. A byte without a stop bit is delivered too, as most adapters do.
    """
    if sent == heard:
        return (value,)
    levels = value << 1 | 1 << (_BITS - 1)  # the start bit is low
    step = sent / heard  # sent bits in a heard one

    def level(at: float) -> int:
        return levels >> int(at) & 1 if 0 <= at < _BITS else 1

    received: list[int] = []
    at = 0.0
    while at < _BITS:
        if level(at):  # wait for a falling edge
            at = int(at) + 1.0
            continue
        bits = [level(at + (number + 0.5) * step) for number in range(_BITS)]
        if not bits[0]:
            received.append(sum(bit << place for place, bit in enumerate(bits[1:9])))
        at += _BITS * step - step / 2
        while at < _BITS and not level(at):  # a low stop bit: the next byte begins after a high one
            at = int(at) + 1.0
    return tuple(received)
