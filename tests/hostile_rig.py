"""Units that misbehave, on simulated time: `hostile:` is the port of one.

Each is polite for a while (a virtual unit answers), then hostile in its own manner for ever, also
on a link that is opened again. All that a program does with it is counted: one that would go on
without end is stopped by `Hangs`. Ctrl-C comes at a time. No real time passes.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from random import Random
from unittest.mock import patch

from link_rig import registered
from mikas.framing import ESCAPE, Decoder, Frame, encode
from mikas.link import Chunk, reconnecting
from mikas.link.flood import ANSWER, BACKLOG, BURST, FASTER
from mikas.link.virtual import VirtualLink
from virtual_harness import make_bus

URL = "hostile:"
BYTE = 10 / 9600
ASKED = encode(b"\x01")
MOST_CALLS = 30_000
CONNECTED = -1.0  # hostile from the first request that is no 01

Pieces = list[tuple[float, bytes]]  # seconds after the request, or after the piece before


class Hangs(BaseException):
    """The program does not end by itself."""


def ctrl_c() -> None:
    raise KeyboardInterrupt


class World:
    """The clock that all links share, and what was done in it."""

    def __init__(self, manner: Manner, since: float, interrupted: float, patience: float) -> None:
        self.manner = manner
        self.since = since
        self.interrupted = interrupted  # when `interrupt` is called
        self.interrupt: Callable[[], None] = ctrl_c
        self.patience = patience  # s that may pass
        self.time = 0.0
        self.calls = 0
        self.calls_after_interrupt = 0
        self.opened = 0
        self.brought = 0  # bytes to the tester
        self.bodies: list[bytes] = []  # of all requests
        self.is_interrupted = False
        self.bus = make_bus()

    def count(self) -> None:
        self.calls += 1
        self.calls_after_interrupt += self.is_interrupted
        if self.calls > MOST_CALLS or self.time > self.patience:
            raise Hangs(f"{self.calls} calls, {self.time:.0f} s")

    def pass_until(self, time: float) -> None:
        """Let time pass; Ctrl-C may come."""
        if not self.is_interrupted and max(time, self.time) >= self.interrupted:
            self.time = max(self.time, min(time, self.interrupted))
            self.is_interrupted = True
            self.interrupt()
        self.time = max(self.time, time)

    def wait(self, seconds: float) -> None:
        self.count()
        self.pass_until(self.time + seconds)

    @property
    def most_bytes(self) -> int:
        """Bytes that a line with bounds can have brought: see `mikas.link.flood`."""
        line = (BURST * self.opened + FASTER * self.time) / BYTE
        return int(line) + ANSWER * len(self.bodies) + 2 * BACKLOG * self.opened

    @property
    def is_hostile(self) -> bool:
        return 0 <= self.since <= self.time

    def takes(self, data: bytes) -> None:
        """Follow a request; the unit may turn hostile."""
        self.bodies += [it.body for it in Decoder().feed(data) if isinstance(it, Frame)]
        if self.since == CONNECTED and data != ASKED:
            self.since = self.time


class Manner:
    """A manner of being hostile: by default, silence. `hangs_up`: the port fails at each use."""

    hangs_up = False

    def __init__(self) -> None:
        self.random = Random(7)
        self.honest = make_bus().ecu.responder
        self.count = 0

    def echo(self, data: bytes) -> bytes:
        return data

    def answer(self, body: bytes) -> Pieces:
        """What comes after a request."""
        return []

    def babble(self) -> tuple[float, bytes] | None:
        """What comes without a request: the seconds until it is there, and the bytes."""
        return None

    def true_answer(self, body: bytes) -> bytes:
        given = self.honest.answer(body, 0.0)
        return given if isinstance(given, bytes) else b"\x01"


class Silence(Manner):
    """1. Nothing comes any more, but the echo."""


class Garbage(Manner):
    """2. Random bytes for ever, at the line's own pace."""

    def babble(self):
        return 32 * BYTE, self.random.randbytes(32)


class Babble(Manner):
    """3. Valid frames that no request caused, for ever."""

    def babble(self):
        self.count += 1
        body = (b"\x0a", b"\x00", b"\x01", b"\x0d\x35", bytes(27))[self.count % 5]
        wire = encode(body)
        return len(wire) * BYTE + 0.002, wire


class OtherAnswers(Manner):
    """4. The right answer to another request."""

    def answer(self, body):
        self.count += 1
        others = ("6129", "01", "02", "51", "21004010", "60", "612929")
        other = bytes.fromhex(others[self.count % len(others)])
        return [(0.005, encode(self.true_answer(other)))]


class Impossible(Manner):
    """5. Empty, endless, too short, too long, and counts that are not so."""

    def answer(self, body):
        self.count += 1
        honest = self.true_answer(body)
        wrong = (
            b"", bytes(1500), honest[:-1], honest + b"\0", b"\xff" + honest[1:], b"\x7f\x01",
            bytes([255]) * 255,
        )  # fmt: skip
        wire = encode(wrong[self.count % len(wrong)])
        return [(0.005 + len(wire) * BYTE, wire)]


class BadEcho(Manner):
    """6. The echo comes altered, doubled or cut; the answer is right."""

    def echo(self, data):
        self.count += 1
        altered = bytes([data[0] ^ 4]) + data[1:]
        return (altered, data + data, data[:-1])[self.count % 3]

    def answer(self, body):
        return [(0.005, encode(self.true_answer(body)))]


class Slow(Manner):
    """7. A frame without end, each byte just before the limit of 0.2 s."""

    def answer(self, body):
        self.count += 1
        return []

    def babble(self):
        return (0.19, b"\x55") if self.count else None


class Refusal(Manner):
    """8. A refusal, an unknown refusal, or silence, in turns; and 01 as another unit each time."""

    def answer(self, body):
        self.count += 1
        if body == b"\x01":
            return [(0.005, encode((b"\x0a", b"\x09", b"\x0a")[self.count % 3]))]
        refusal = (b"\x01", b"\x7f", b"\x0f\x01", b"")[self.count % 4]
        return [(0.005, encode(refusal))] if refusal else []


class Changeling(Manner):
    """8. All is well but the passports, which differ at each reading."""

    def answer(self, body):
        self.count += 1
        if 0x51 <= body[0] <= 0x58:
            return [(0.005, encode(f"UNIT {self.count}".encode().ljust(16, b"\0")))]
        answer = self.honest.answer(body, 0.0)
        return [(0.005, encode(answer))] if isinstance(answer, bytes) else []


class Flood(Manner):
    """9. A hundred megabytes a second, for ever."""

    def babble(self):
        return 4096 / 100e6, self.random.randbytes(64) * 64


class EndlessFrame(Manner):
    """9. One frame at full speed, which never ends."""

    def babble(self):
        return 4096 / 100e6, bytes([ESCAPE]) * 4096


class EndlessStream(Manner):
    """9. Sets of a stream at 10,000 Hz, which nothing stops."""

    def babble(self):
        return 1e-3, encode(bytes(27)) * 10


class HangsUp(Manner):
    """The port opens, and fails at once, as of a program that shares an adapter and has none."""

    hangs_up = True


MANNERS: tuple[type[Manner], ...] = (
    Silence, Garbage, Babble, OtherAnswers, Impossible, BadEcho, Slow, Refusal, Changeling, Flood,
    EndlessFrame, EndlessStream, HangsUp,
)  # fmt: skip


class HostileLink(VirtualLink):
    """The adapter: a unit that is polite, then what `Manner` sends."""

    is_virtual = False

    def __init__(self, world: World) -> None:
        super().__init__(world.bus, url=URL, start=world.time)
        self.world = world
        world.opened += 1
        self._coming: deque[tuple[float, bytes]] = deque()
        self._next: tuple[float, bytes] | None = None

    def now(self) -> float:
        self._now = max(self._now, self.world.time)
        return self._now

    def write(self, data: bytes) -> None:
        self.world.count()
        self._check()
        self.world.takes(data)
        if not self.world.is_hostile:
            super().write(data)
            return
        manner = self.world.manner
        sent = self.now() + len(data) * BYTE
        self._coming = deque([(sent, manner.echo(data))])
        for event in Decoder().feed(data):
            if isinstance(event, Frame):
                for delay, piece in manner.answer(event.body):
                    sent += delay
                    self._coming.append((sent, piece))

    def read(self, deadline: float) -> Chunk:
        self.world.count()
        self._check()
        if not self.world.is_hostile:
            chunk = super().read(deadline)
            self.world.pass_until(chunk.time)
        else:
            chunk = self._hostile(deadline)
        self.world.brought += len(chunk.data)
        return chunk

    def _check(self) -> None:
        if self.world.is_hostile and self.world.manner.hangs_up:
            self.unplug()
        super()._check()

    def _hostile(self, deadline: float) -> Chunk:
        now = self.now()
        if self._next is None and (babble := self.world.manner.babble()) is not None:
            self._next = now + babble[0], babble[1]
        source = [it for it in (self._next, self._coming[0] if self._coming else None) if it]
        first = min(source, default=None)
        if first is None or first[0] > max(deadline, now):
            self.world.pass_until(max(deadline, now))
            return Chunk(b"", self.now())
        if first is self._next:
            self._next = None
        else:
            self._coming.popleft()
        self.world.pass_until(first[0])
        return Chunk(first[1], self.now())

    def gather(self, until: float) -> None:
        self.world.pass_until(until)

    def send_break(self, seconds: float) -> None:
        self.world.count()
        self._check()
        if not self.world.is_hostile:
            self.world.bus.send_break(seconds, self.now())
        self._coming.clear()
        self.world.pass_until(self.world.time + seconds)

    def set_baud(self, baud: int) -> bool:
        self.world.count()
        self._check()
        self.baud = baud
        if not self.world.is_hostile:
            self.world.bus.set_baud(baud)
        return True


@contextmanager
def hostile(
    manner: type[Manner],
    *,
    since: float = CONNECTED,
    interrupted: float = float("inf"),
    patience: float = 600.0,
) -> Iterator[World]:
    """`hostile:` is a unit of this manner `since` a time; all of mikas' waits are in its world."""
    world = World(manner(), since, interrupted, patience)
    init = reconnecting.ReconnectingPort.__init__

    def in_world(port: reconnecting.ReconnectingPort, *args: object, **settings: object) -> None:
        init(port, *args, **(settings | {"wait": world.wait}))

    with (
        registered("hostile", lambda *_: HostileLink(world)),
        patch.object(reconnecting.ReconnectingPort, "__init__", in_world),
        patch.object(reconnecting.ReconnectingPort, "now", lambda _: world.time),
    ):
        yield world
