"""Sessions of the real tester with a virtual unit, and the truth about them: which data the unit
gave to which request. The data never repeat: a value in a wrong place can't pass for a right one.
"""

# ruff: noqa: ARG002  (the car's methods have the arguments of its protocol)

from __future__ import annotations

from contextlib import closing, suppress
from dataclasses import dataclass, field
from itertools import islice
from math import inf
from random import Random
from typing import Final, NamedTuple, cast

from mikas.catalog import shipped
from mikas.client import Ecu
from mikas.client.parameters.polling import FixedMethod
from mikas.errors import MikasError
from mikas.link.base import CaptureTee, Direction
from mikas.link.virtual import VirtualLink
from mikas.recording.capture.coalescer import Coalescer
from mikas.recording.capture.notes import Note
from mikas.recording.capture.writer import CaptureWriter
from mikas.tester import Tester
from mikas.virtual.bus import AdapterKind, Bus
from mikas.virtual.ecu import VirtualEcu
from mikas.virtual.fault_injector import FaultInjector, LineFault
from mikas.virtual.responder import Answer, Identity, Responder, Stream

CATALOG: Final = shipped()
METHODS: Final[tuple[FixedMethod, ...]] = (
    "single",
    "batch",
    "list",
    "stream",
    "stroke0",
    "stroke3",
)
_NAMES: Final = tuple(p.name for p in CATALOG.parameters)
_SIZES: Final = dict(CATALOG.codes)
_RPM: Final = 3000.0
_CYCLE: Final = 120 / _RPM

Plan = tuple[tuple[FixedMethod, tuple[str, ...], int], ...]
"""In order: the method, the names of the parameters, the number of readings."""


class Packet(NamedTuple):
    """A packet of the line. `origin`: its number in the session as it was recorded; -1: invented.
    `changed`: not as it was recorded. `missing`: not a packet, but a damaged part.
    """

    sent: bool
    data: bytes
    time: float
    origin: int
    port: int = 0
    changed: bool = False
    missing: bool = False


@dataclass(slots=True)
class Truth:
    """What the unit gave. `data`: (request, list of codes, response), as bodies; `other`: pairs."""

    data: set[tuple[bytes, bytes, bytes]] = field(default_factory=set)
    other: set[tuple[bytes, bytes]] = field(default_factory=set)

    def add(self, more: Truth) -> None:
        self.data |= more.data
        self.other |= more.other


class RestlessCar:
    """No datum is ever the same again. None is 01, which D10 knows as a refusal too."""

    def __init__(self) -> None:
        self.codes = tuple(_SIZES)
        self.faults = [0x0D, 0x35]

    def size_of(self, code: int) -> int | None:
        return _SIZES.get(code)

    def raw(self, code: int, now: float) -> bytes:
        datum = Random(f"{code} {now}").randbytes(_SIZES[code])
        return b"\x02" if datum == b"\x01" else datum

    def write(self, code: int, data: bytes) -> bool:
        return False

    def powered(self, now: float) -> bool:
        return True

    def next_change(self, after: float) -> float:
        return inf

    def next_stroke(self, stroke: int, after: float) -> float:
        offset = max(0, stroke - 1) * _CYCLE / 4
        count = int((after - offset) / _CYCLE) + 1
        return count * _CYCLE + offset

    def engine_speed(self, now: float) -> float:
        return _RPM

    def power_cycle(self) -> None:
        pass


class WatchedResponder(Responder):
    """Notes each answer."""

    def __init__(self) -> None:
        super().__init__(RestlessCar(), Identity(0x0A))
        self.truth = Truth()
        self._listed = b""
        self._stream = b""

    def answer(self, body: bytes, now: float) -> Answer:
        answer = super().answer(body, now)
        if body[:1] == b"\x64" and answer == b"\x00":
            self._listed = body[1:]
        if not isinstance(answer, bytes):
            self._stream = body
        elif body[:1] in (b"\x61", b"\x63"):
            codes = self._listed if body == b"\x63" else body[1:]
            self.truth.data.add((body, codes, answer))
        else:
            self.truth.other.add((body, answer))
        return answer

    def response_of(self, stream: Stream, now: float) -> bytes:
        body = super().response_of(stream, now)
        self.truth.data.add((self._stream, self._stream[1:], body))
        return body


class _Tape:
    """Takes a session as packets."""

    def __init__(self) -> None:
        self.packets: list[Packet] = []

    def record(self, direction: Direction, data: bytes, time: float) -> None:
        time = round(time, 6)  # as a file keeps it
        self.packets.append(Packet(direction is Direction.SENT, data, time, len(self.packets)))

    def note(self, note: Note) -> None:
        pass


@dataclass(frozen=True, slots=True)
class Session:
    """A recorded session. `echoes`: of the adapter; `faults`: whether the line was a bad one."""

    packets: tuple[Packet, ...]
    truth: Truth
    echoes: bool
    faults: bool


def session(
    plan: Plan,
    adapter: AdapterKind | None = None,
    faults: FaultInjector | None = None,
    *,
    joined: bool = True,
) -> Session:
    """Record a session by the plan, on simulated time. `joined`: in packets as `mikas log` has."""
    responder, tape = WatchedResponder(), _Tape()
    sink = Coalescer(cast(CaptureWriter, tape)) if joined else tape
    adapter = adapter or AdapterKind()
    bus = Bus(VirtualEcu(responder), adapter=adapter, fault_injector=faults)
    link = CaptureTee(VirtualLink(bus, start=1000.0), sink)
    with Ecu(Tester(link), CATALOG) as ecu:
        for method, names, count in plan:
            with suppress(MikasError):  # the line was too bad; what came up to there counts
                if ecu.tester.version_code is None:
                    ecu.tester.connect()
                with closing(ecu.watch(*names, method=method)) as samples:
                    for _ in islice(samples, count):
                        pass
                ecu.faults()
    if isinstance(sink, Coalescer):
        sink.flush()
    return Session(tuple(tape.packets), responder.truth, adapter.echo, faults is not None)


def drawn(random: Random) -> Session:
    """Record a session that `random` decides on: one to four methods, mostly on a sound line."""
    few = tuple(random.sample(_NAMES, random.choice((1, 2, 3, 5))))
    plan: list[tuple[FixedMethod, tuple[str, ...], int]] = []
    for _ in range(random.choice((1, 2, 3, 4))):
        names = random.choice((few, _alike(random, few), tuple(random.sample(_NAMES, 3))))
        plan.append((random.choice(METHODS), names, random.choice((1, 2, 4))))
    if random.random() < 0.2:  # a list after a list
        plan += [("list", few, 2), ("list", _alike(random, few), 2)]
    adapter = AdapterKind(echo=random.random() < 0.6, latency=random.choice((0.0, 0.0, 0.016)))
    faults = None
    if random.random() < 0.25:
        kinds = random.sample(list(LineFault), random.choice((1, 2, 3)))
        rates = dict.fromkeys(kinds, random.choice((0.03, 0.1)))
        faults = FaultInjector(rates, seed=random.randrange(1 << 16))
    return session(tuple(plan), adapter, faults, joined=random.random() < 0.85)


def _alike(random: Random, names: tuple[str, ...]) -> tuple[str, ...]:
    """Return other parameters whose data have the same sizes, so that only the request differs."""
    found: list[str] = []
    for name in names:
        size = CATALOG.parameter(name).size
        others = [p.name for p in CATALOG.parameters if p.size == size and p.name not in found]
        found.append(random.choice(others))
    return tuple(found)
