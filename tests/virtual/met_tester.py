"""A tester that asks a virtual unit in the way that the unit's profile demands."""

from __future__ import annotations

from dataclasses import replace

from mikas.framing import Decoder, Frame, encode
from mikas.virtual.build import met_bus
from mikas.virtual.quirks import ChecksumForm
from mikas.virtual.unit_profile import UnitProfile

BYTE = 10 / 9600
_PATIENCE = 1.5  # s of silence after which nothing more comes: more than every pause here


def with_commands(profile: UnitProfile, *codes: int) -> UnitProfile:
    """`profile` of a unit that has these commands."""
    return replace(profile, missing=profile.missing - frozenset(codes))


class MetTester:
    """`times`: the ends of the bytes that came after the echo of the latest request."""

    def __init__(self, profile: UnitProfile, **settings: str) -> None:
        self.profile = profile
        self.bus = met_bus(profile, settings)
        self.now = 0.0
        self.times: list[float] = []
        self.echo = b""

    @property
    def refusal(self) -> bytes | None:
        """The body that an unknown request gets; None: silence."""
        unknown = self.profile.unknown
        return None if unknown in (None, "silent") else bytes.fromhex(unknown)

    def wire(self, body: bytes) -> bytes:
        """A request in the form that the unit understands."""
        return encode(body, raw_checksum=self.profile.accepts is ChecksumForm.RAW)

    def say(self, wire: bytes) -> float:
        """Sends bytes, a while after the latest ones; returns when the last has left."""
        self.now += 0.25  # more than each least pause here
        self.bus.send(wire, self.now)
        return self.now + len(wire) * BYTE

    def came(self, wire: bytes, seconds: float | None = None) -> bytes:
        """What comes after `wire`, for `seconds` or until nothing does."""
        end = self.say(wire)
        heard, latest = [], end
        while (due := self.bus.next_event()) <= (
            latest + _PATIENCE if seconds is None else end + seconds
        ):
            self.now = max(self.now, due)
            data, time = self.bus.collect_received(self.now)
            heard += [(time, value) for value in data]
            latest = max(latest, self.now) if data else latest
        self.now = max(self.now, latest if seconds is None else end + seconds)
        echoed = len(wire) if self.bus.adapter.kind.echo else 0
        self.echo = bytes(value for _, value in heard[:echoed])
        self.times = [time for time, _ in heard[echoed:]]
        return bytes(value for _, value in heard[echoed:])

    def ask(self, body: bytes) -> bytes | None:
        """The body of the only response to a request; None: silence."""
        came = self.came(self.wire(body))
        if not came:
            return None
        (event,) = Decoder().feed(came)
        assert isinstance(event, Frame)
        return event.body

    def bodies(self, body: bytes, seconds: float) -> list[bytes]:
        """The bodies of the responses that come within `seconds`."""
        events = Decoder().feed(self.came(self.wire(body), seconds))
        assert all(isinstance(event, Frame) for event in events)
        return [event.body for event in events]
