"""Changes to a line as bad lines and damaged files cause them: of bytes, of packets, of times.

None is a change that nothing on the line tells from a true one: no whole frame of the right length
in the right place, no byte that leaves a checksum as it is (00), nothing out of one response in
another order (§2: the checksum is a sum), no two changes of one exchange.
"""

# ruff: noqa: ARG001  (all mutations are called alike)

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from random import Random
from typing import Final

from fuzz.exchanges.sessions import Packet
from mikas.framing import encode

Line = list[Packet]
Mutation = Callable[[Random, Line, int], Line]
"""Returns the line changed at a packet, or the line itself: not there."""

_PAUSES: Final = (0.001, 0.005, 0.021, 0.3)
_DELAYS: Final = (0.005, 0.03, 0.3, 0.6, 1.5)
_AVAILABILITY: Final = encode(b"\x01")
_READ_LIST: Final = encode(b"\x63")
_STREAMS: Final = tuple(bytes([it]) for it in b"\x71\x7f\x80\x81\x82\x83")


def mutated(random: Random, line: Line) -> tuple[Line, list[str]]:
    """Return the line with one to three changes, far from one another, and their names."""
    names: list[str] = []
    kept = line
    if random.random() < 0.1 and len(line) > 12:  # a file that begins in the middle
        kept = line[random.randrange(1, len(line) // 2) :]
        names.append("begin")
    used: list[int] = []
    for _ in range(random.choice((1, 1, 1, 2, 3))):
        name = random.choice(tuple(MUTATIONS))
        mutate = MUTATIONS[name]
        for _ in range(8):  # until a place fits
            turn = _turn(kept, at := random.randrange(len(kept)))
            if any(abs(turn - each) < 4 for each in used):
                continue
            new = mutate(random, kept, at)
            if new is not kept:
                kept = new
                used.append(turn)
                names.append(name)
                break
    return kept, names


def _turn(line: Line, at: int) -> int:
    """Return the number of requests up to a packet."""
    return sum(it.sent for it in line[: at + 1])


def _changed(line: Line, at: int, data: bytes) -> Line:
    return [*line[:at], line[at]._replace(data=data, changed=True), *line[at + 1 :]]


def _flipped(*, sent: bool) -> Mutation:
    def flip(random: Random, line: Line, at: int) -> Line:
        if line[at].sent is not sent or line[at].missing:
            return line
        data = bytearray(line[at].data)
        data[random.randrange(len(data))] ^= 1 << random.randrange(8)
        return _changed(line, at, bytes(data))

    return flip


def _byte_inserted(random: Random, line: Line, at: int) -> Line:
    data, place = line[at].data, random.randrange(len(line[at].data) + 1)
    new = random.choice((random.randrange(1, 256), 0x0D, 0x40))
    return _changed(line, at, data[:place] + bytes([new]) + data[place:])


def _zero_in_echo(random: Random, line: Line, at: int) -> Line:
    """A frame of noise, or zeros, in an echo."""
    if not _is_echo(line, at):
        return line
    data, place = line[at].data, random.randrange(len(line[at - 1].data))
    new = random.choice((b"\x00", b"\x00\x0d", b"\x00\x00\x0d", encode(random.randbytes(1))))
    return _changed(line, at, data[:place] + new + data[place:])


def _byte_dropped(random: Random, line: Line, at: int) -> Line:
    data = line[at].data
    place = random.randrange(len(data)) if data else 0
    if len(data) < 2 or not data[place]:
        return line
    return _changed(line, at, data[:place] + data[place + 1 :])


def _byte_doubled(random: Random, line: Line, at: int) -> Line:
    data = line[at].data
    place = random.randrange(len(data)) if data else 0
    if not data or not data[place]:
        return line
    return _changed(line, at, data[:place] + data[place : place + 1] + data[place:])


def _dropped(random: Random, line: Line, at: int) -> Line:
    if _leaves_checksum(line[at]) or _ends_stream(line, at):
        return line
    return [*line[:at], *line[at + 1 :]]


def _doubled(random: Random, line: Line, at: int) -> Line:
    if _leaves_checksum(line[at]):
        return line
    return [*line[: at + 1], line[at]._replace(origin=-1, changed=True), *line[at + 1 :]]


def _swapped(random: Random, line: Line, at: int) -> Line:
    if at + 1 >= len(line):
        return line
    one, other = line[at], line[at + 1]
    if one.sent is other.sent and not (_is_whole(one) and _is_whole(other)):
        return line
    if _ends_stream(line, at):
        return line
    if random.random() < 0.5:
        one, other = one._replace(time=other.time), other._replace(time=one.time)
    return [*line[:at], other, one, *line[at + 2 :]]


def _moved(random: Random, line: Line, at: int) -> Line:
    """Let a packet come behind some of the next ones."""
    behind = at + random.choice((1, 2, 3))
    if behind >= len(line) or not all(map(_is_whole, line[at : behind + 1])):
        return line
    if any(_ends_stream(line, each) for each in range(at, behind + 1)):
        return line
    late = line[at]._replace(time=line[behind].time)
    return [*line[:at], *line[at + 1 : behind + 1], late, *line[behind + 1 :]]


def _delayed(random: Random, line: Line, at: int) -> Line:
    """Let a packet, or all from there on, come later."""
    delay = random.choice(_DELAYS)
    stop = random.choice((at + 1, len(line)))
    late = [it._replace(time=it.time + delay) for it in line[at:stop]]
    return [*line[:at], *late, *line[stop:]]


def _clock_set(random: Random, line: Line, at: int) -> Line:
    delay = random.choice((-3600.0, -2.0, -0.7, 90_000.0))
    return [*line[:at], *(it._replace(time=max(0.0, it.time + delay)) for it in line[at:])]


def _merged(random: Random, line: Line, at: int) -> Line:
    stop = at + random.choice((2, 2, 3, 6))
    same = line[at:stop]
    if len(same) < 2 or any(it.sent is not line[at].sent or it.missing for it in same):
        return line
    data = b"".join(it.data for it in same)
    return [*line[:at], same[-1]._replace(data=data, changed=True), *line[stop:]]


def _split(random: Random, line: Line, at: int) -> Line:
    it = line[at]
    if len(it.data) < 2:
        return line
    place = random.randrange(1, len(it.data))
    pause = random.choice(_PAUSES)
    first = it._replace(data=it.data[:place], time=it.time - pause, changed=True)
    return [*line[:at], first, it._replace(data=it.data[place:], changed=True), *line[at + 1 :]]


def _noise(random: Random, line: Line, at: int) -> Line:
    """Insert bytes that are no frame."""
    data = random.choice((random.randbytes(random.choice((1, 2, 5))), b"\0" * 9, b"\r", b"\r\r"))
    if sum(data[:-1]) % 256 == 0 and data[-1:] == b"\r" and len(data) > 1:
        return line
    return [*line[:at], _new(line[at], data), *line[at:]]


def _frame_before_echo(random: Random, line: Line, at: int) -> Line:
    """Insert a whole frame between a request and its echo."""
    if not _is_echo(line, at):
        return line
    return [*line[:at], _new(line[at], _frame(random, line)), *line[at:]]


def _second_response(random: Random, line: Line, at: int) -> Line:
    """Insert a whole frame behind a response."""
    if at < 2 or not line[at].sent or not _is_whole(line[at - 1]) or line[at - 1].sent:
        return line
    request = next((it.data for it in reversed(line[:at]) if it.sent), b"")
    if _is_streaming(line, at) or line[at - 1].data == request:
        return line  # it would be the next response, or the only one
    return [*line[:at], _new(line[at - 1], _frame(random, line)), *line[at:]]


def _echo_lost(random: Random, line: Line, at: int) -> Line:
    return [*line[:at], *line[at + 1 :]] if _is_echo(line, at) else line


def _list_not_set(random: Random, line: Line, at: int) -> Line:
    """Spoil the setting of a list: its request, its echo, or its response. Behind it the tester may
    have synchronized.
    """
    places = [
        number
        for number, it in enumerate(line[:-2])
        if it.sent and it.data[:1] == b"\x64" and _is_whole(it)
    ]
    if not places:
        return line
    place = random.choice(places) + random.choice((0, 0, 1, 2))
    spoil = random.choice((_flipped(sent=line[place].sent), _byte_dropped, _dropped))
    spoilt = spoil(random, line, place)
    return spoilt if spoilt is line or random.random() < 0.5 else _synchronized(spoilt, place)


def _synchronized(line: Line, place: int) -> Line:
    """Let a clean `01` come before the next request for a list."""
    asks = (at for at, it in enumerate(line) if at >= place and it.sent and it.data == _READ_LIST)
    sent = [at for at, it in enumerate(line) if it.sent]
    pairs = pairwise(sent)
    whole = ((one, two) for one, two in pairs if line[one].data == _AVAILABILITY and two - one > 1)
    at, (one, two) = next(asks, 0), next(whole, (0, 0))
    if not (at and two):
        return line
    shift = line[at - 1].time + 0.6 - line[one].time
    clean = [it._replace(time=it.time + shift, origin=-1, changed=True) for it in line[one:two]]
    return [*line[:at], *clean, *(it._replace(time=it.time + 1.2) for it in line[at:])]


def _begin_of_one(random: Random, line: Line, at: int) -> Line:
    """Let the line begin with one `01`, whose echo is damaged."""
    first = next((n for n, it in enumerate(line) if it.sent and it.data[:1] != b"\x01"), 0)
    before = [n for n in range(first) if line[n].sent]
    if not before or not _is_echo(line, before[-1] + 1):
        return line
    kept = line[before[-1] :]
    return random.choice((_flipped(sent=False), _byte_dropped, _echo_lost))(random, kept, 1)


def _part_missing(random: Random, line: Line, at: int) -> Line:
    """Damage blocks: a reader knows that something is missing there."""
    stop = at + random.choice((0, 1, 1, 2, 3, 5, 8, 30))
    if _is_streaming(line, at) and any(it.sent for it in line[at:stop]):
        return line  # a stream goes on behind a missing part: that part may have had no request
    gone = line[at]._replace(data=b"", changed=True, missing=True)
    return [*line[:at], gone, *line[stop:]]


def _new(beside: Packet, data: bytes) -> Packet:
    return beside._replace(sent=False, data=data, origin=-1, changed=True)


def _frame(random: Random, line: Line) -> bytes:
    """Return a frame: of the line, or another one."""
    own = [it.data for it in line if _is_whole(it) and it.data]
    return random.choice((*own, encode(random.randbytes(random.choice((1, 1, 2, 3))))))


def _is_streaming(line: Line, at: int) -> bool:
    """Return whether the request before is a stream's."""
    request = next((it.data for it in reversed(line[:at]) if it.sent), b"")
    return request[:1] in _STREAMS


def _ends_stream(line: Line, at: int) -> bool:
    """Return whether this is the `01` that ends a stream: without it, its echo is a datum."""
    return line[at].sent and _is_streaming(line, at)


def _is_whole(packet: Packet) -> bool:
    return packet.data[-1:] == b"\r"


def _is_echo(line: Line, at: int) -> bool:
    """Return whether the packet begins with the echo of the request before."""
    if not 0 < at < len(line) or line[at].sent or not line[at - 1].sent:
        return False
    return line[at].data.startswith(line[at - 1].data)


def _leaves_checksum(packet: Packet) -> bool:
    return not _is_whole(packet) and sum(packet.data) % 256 == 0


MUTATIONS: Final[dict[str, Mutation]] = {
    "flip sent": _flipped(sent=True),
    "flip received": _flipped(sent=False),
    "byte inserted": _byte_inserted,
    "zero in an echo": _zero_in_echo,
    "byte dropped": _byte_dropped,
    "byte doubled": _byte_doubled,
    "packet dropped": _dropped,
    "packet doubled": _doubled,
    "swapped": _swapped,
    "moved": _moved,
    "delayed": _delayed,
    "clock set": _clock_set,
    "merged": _merged,
    "split": _split,
    "noise": _noise,
    "frame before the echo": _frame_before_echo,
    "second response": _second_response,
    "echo lost": _echo_lost,
    "list not set": _list_not_set,
    "begin with one 01": _begin_of_one,
    "part missing": _part_missing,
}
