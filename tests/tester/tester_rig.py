"""What the tests of the tester share: a unit with data of their own, and links that misbehave."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from heapq import heappop, heappush

from mikas import commands as c
from mikas.errors import LinkLost
from mikas.framing import Decoder, Frame, encode
from mikas.i18n import Text
from mikas.link import Chunk, Link, LinkWrapper
from mikas.link.base import AwaitedAnswer
from mikas.link.virtual import VirtualLink
from mikas.tester import Tester
from mikas.virtual.bus import AdapterKind, Bus, Stalls
from mikas.virtual.ecu import EcuEvent, VirtualEcu
from mikas.virtual.fault_injector import FaultInjector, LineFault, Sent
from mikas.virtual.quirks import EcuQuirks
from mikas.virtual.responder import Identity, Responder
from virtual_harness import TableCar

VERSION = 0x0A

# All different; among them what a version code, a completion code, an escape, a terminator and a
# stretch of noise look like.
ONE_BYTE = dict(
    enumerate((b"\x0a", b"\x09", b"\x00", b"\x01", b"\x0d", b"\x40", b"\x55", b"\xf3", b"\xff"), 16)
)
TWO_BYTES = dict(enumerate((b"\x0a\x09", b"\x0d\x0d", b"\x00\x00", b"\x12\x34", b"\x40\xcd"), 64))
DATA = ONE_BYTE | TWO_BYTES

ECHOING = AdapterKind()
SILENT_ADAPTER = AdapterKind(echo=False)
SLOW = AdapterKind(latency=0.016)
SLOW_AND_SILENT = AdapterKind(echo=False, latency=0.016)
DEAD = AdapterKind(supplied=False)
ADAPTERS = [ECHOING, SILENT_ADAPTER, SLOW, SLOW_AND_SILENT]


@contextmanager
def case(*what: object) -> Iterator[None]:
    """Name the case of a loop in the traceback of its failure."""
    try:
        yield
    except BaseException as failure:
        failure.add_note(f"case: {', '.join(map(str, what))}")
        raise


def adapter_name(kind: AdapterKind) -> str:
    return f"{'echo' if kind.echo else 'no-echo'}-{kind.latency * 1000:g}ms"


class Watched:
    """A unit on its wire, and every event of its watcher."""

    def __init__(
        self,
        *,
        adapter: AdapterKind = ECHOING,
        fault_injector: FaultInjector | None = None,
        stalls: Stalls | None = None,
        rpm: float = 850.0,
        version: int = VERSION,
        data: dict[int, bytes] = DATA,
        **quirks: object,
    ) -> None:
        self.car = TableCar(data, faults=[13, 53], rpm=rpm)
        self.happenings: list[EcuEvent] = []
        responder = Responder(self.car, Identity(version), EcuQuirks(**quirks))
        self.ecu = VirtualEcu(responder, watcher=self.happenings.append)
        self.fault_injector = fault_injector or FaultInjector()
        self.bus = Bus(self.ecu, adapter=adapter, fault_injector=self.fault_injector, stalls=stalls)
        self.link = VirtualLink(self.bus)

    def tester(self, link: Link | None = None, **settings: object) -> Tester:
        """A tester that is not yet connected."""
        return Tester(link or self.link, **settings)

    def connected(self, link: Link | None = None, **settings: object) -> Tester:
        tester = self.tester(link, **settings)
        assert tester.connect() == self.ecu.responder.identity.version_code
        return tester

    def heard(self, body: bytes) -> int:
        """How often the unit has heard this request."""
        return sum(h.kind == "request" and h.data == body for h in self.happenings)

    def count_of(self, kind: str) -> int:
        return sum(h.kind == kind for h in self.happenings)


def read(code: int, size: int | None = None) -> c.ReadParameters:
    return c.ReadParameters((c.Datum(code, size or len(DATA[code])),))


READS = [
    c.Availability(),
    c.ReadFaults(),
    c.ReadRamByte(0x20),
    c.ReadXramByte(0x1234),
    c.ReadCodeByte(0x400D),
    c.ReadSfr(0x81),
    c.ReadRamBlock(3, 5),
    c.ReadXramBlock(0x100, 40),
    c.ReadCodeBlock(0x0D0D, 3),
    c.ReadProgramPassport(2),
    c.ReadDataPassport(5),
    c.CountParameters(),
    c.ReadParameters(tuple(c.Datum(code, len(DATA[code])) for code in DATA)),
    read(16),
]
"""Every family of commands that only read."""


def right(tester: Tester, *codes: int) -> None:
    """What these parameters read as is what they are."""
    for code in codes or (16, 17, 22, 67):
        assert tester.request(read(code)) == (DATA[code],)


class Fate(FaultInjector):
    """Gives each response its line fault and delay in turn, echoes included; then no faults."""

    def __init__(self, fates: Iterable[tuple[LineFault | None, float]], seed: int = 0) -> None:
        super().__init__(seed=seed)
        self.fates = iter(fates)

    def respond(self, wire: bytes) -> list[Sent]:
        line_fault, self.late_by = next(self.fates, (None, 0.0))
        self.next(line_fault)
        return super().respond(wire)


class ScriptedLink(Link):
    """A simulated link whose far end is a function from what was written to what comes back.

    `answer` gives pieces, each with its delay in seconds behind the end of the request.
    """

    def __init__(
        self, answer: Callable[[bytes], list[tuple[float, bytes]]], *, echo: bool = True
    ) -> None:
        self.url = "scripted:"
        self.answer = answer
        self.echo = echo
        self.sent: list[bytes] = []
        self.breaks = 0
        self._now = 0.0
        self._count = 0
        self.coming: list[tuple[float, int, bytes]] = []

    def arrive(self, time: float, data: bytes) -> None:
        self._count += 1
        heappush(self.coming, (time, self._count, data))

    def write(self, data: bytes) -> None:
        self.sent.append(data)
        out = self._now + len(data) * self.byte_time
        if self.echo:
            self.arrive(out, data)
        for delay, piece in self.answer(data):
            self.arrive(out + delay, piece)

    def read(self, deadline: float) -> Chunk:
        if self.coming and self.coming[0][0] <= max(deadline, self._now):
            time, _, data = heappop(self.coming)
            self._now = max(self._now, time)
            return Chunk(data, self._now)
        self._now = max(self._now, deadline)
        return Chunk(b"", self._now)

    def now(self) -> float:
        return self._now

    def send_break(self, seconds: float) -> None:
        self.breaks += 1
        self._now += seconds

    def close(self) -> None:
        pass


def answering(answers: dict[bytes, bytes], **settings: object) -> ScriptedLink:
    """A unit that says what stands here, as it stands, to each request's body."""
    wires = {encode(b"\x01"): encode(bytes([VERSION]))}
    wires |= {encode(body): wire for body, wire in answers.items()}
    return ScriptedLink(lambda sent: [(0.005, wires[sent])] if wires.get(sent) else [], **settings)


class SelfWriting(LinkWrapper):
    """`link`, which itself writes what follows an answer (`Link.write_after`), as the page's does.

    `wrote`: what it has written so.
    """

    def __init__(self, link: Link) -> None:
        super().__init__(link)
        self.wrote: list[bytes] = []
        self._heard = b""
        self._next: tuple[AwaitedAnswer, bytes] | None = None
        self._at: float | None = None

    def write(self, data: bytes) -> None:
        assert self._next is None, "a request was not taken back"
        self._heard = b""
        self.link.write(data)

    def read(self, deadline: float) -> Chunk:
        assert self._at is None, "the tester does not know what it reads an answer to"
        chunk = self.link.read(deadline)
        self._heard += chunk.data
        self._go_on()
        return chunk

    def write_after(self, answer: AwaitedAnswer, data: bytes) -> bool:
        assert self._next is None, "a request was not taken back"
        self._next = answer, data
        self._go_on()
        return True

    def take_back(self) -> float | None:
        at, self._at, self._next = self._at, None, None
        return at

    def _go_on(self) -> None:
        if self._next is None:
            return
        (echo, length), data = self._next
        events = Decoder(strict=True).feed(self._heard.removeprefix(echo))
        whole = [it.wire for it in events if isinstance(it, Frame) and len(it.body) == length]
        if [self._heard] == [echo + it for it in whole]:
            self._at, self._heard = self.link.now(), b""
            self.link.write(data)
            self.wrote.append(data)


class StrikingLink(VirtualLink):
    """Does `strike` once, just before its operation number `at` (reads, writes and breaks)."""

    def __init__(self, bus: Bus, at: int, strike: Callable[[StrikingLink], None]) -> None:
        super().__init__(bus)
        self.operations = 0
        self.at = at
        self.strike = strike

    def _operate(self) -> None:
        self.operations += 1
        assert self.operations < 20_000, "it hangs"
        if self.operations == self.at:
            self.strike(self)

    def write(self, data: bytes) -> None:
        self._operate()
        super().write(data)

    def read(self, deadline: float) -> Chunk:
        self._operate()
        return super().read(deadline)

    def send_break(self, seconds: float) -> None:
        self._operate()
        super().send_break(seconds)


class BreaklessLink(VirtualLink):
    """A port with no means to send a break: the time just passes."""

    can_break = False

    def send_break(self, seconds: float) -> None:
        self._now += seconds


def unplugged(link: VirtualLink) -> LinkLost:
    return LinkLost(url=link.url, problem=Text("", ""), time=link.now())


def make(link: Link, **settings: object) -> Tester:
    """pytest would take the class itself for a test's."""
    return Tester(link, **settings)
