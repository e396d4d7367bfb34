"""An hour in town on simulated time, with a λ meter that is unplugged at random and a GPS that is
not; and the same hour without them. For the desktop, over a pty, and for the page's Python.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from mikas.catalog import shipped
from mikas.client.connecting import ConnectionOptions
from mikas.errors import LinkLost
from mikas.i18n import Text
from mikas.instruments.choosing import ChosenInstrument, chosen_instruments
from mikas.instruments.reading import InstrumentState
from mikas.instruments.session_instruments import SessionInstruments
from mikas.instruments.sources import InstrumentSource
from mikas.instruments.virtual_source import VirtualSource
from mikas.link.base import Chunk
from mikas.live.progress import Length
from mikas.live.session import Session
from mikas.live.starting import prepared
from mikas.recording.capture.instruments import (
    CONNECTED,
    instrument_packets,
    label_and_name,
    loss,
    loss_of,
)
from mikas.recording.capture.reader import CaptureReader, Packet
from mikas.recording.recorder import Recorder
from mikas.sampling.events import Sampled
from mikas.sampling.instrument_changes import InstrumentChanged

CITY = "sim:?clock=simulated&seed=3&scenario=city"
BOTH = ("aem=sim:", "nmea=sim:")
_HOUR = 3600.0  # s
HALF = b"1"  # of a line, at which it is pulled out


def prepare(
    path: Path,
    instruments: tuple[str, ...],
    *,
    duration: float,
    rate: float | None = None,
    channels: tuple[str, ...] = ("FREQ", "VALF"),
) -> Session:
    """Return the session of a drive in town that is recorded to `path`."""
    return prepared(
        CITY,
        ConnectionOptions(),
        channels,
        Length(None, duration, rate),
        method="batch",
        recorder=Recorder(),
        record=path,
        wants_faults=lambda: False,
        instruments=chosen_instruments(instruments, shipped()),
    )


def unit_of(path: Path) -> list[tuple[bytes, float]]:
    """Return the unit's bytes in a recording, with their times."""
    return [(it.data, it.time) for it in CaptureReader(path) if isinstance(it, Packet)]


class Outages:
    """When an instrument is out of its socket: 0.1 to 60 s, after 5 to 120 s in it."""

    def __init__(self, now: Callable[[], float], seed: int) -> None:
        self.now = now
        self._random = random.Random(seed)
        self._next = 30.0
        self._back = 0.0
        self.count = 0

    def begins(self) -> bool:
        """Whether it is pulled out now."""
        now = self.now()
        if now < self._next:
            return False
        self._back = now + self._random.uniform(0.1, 60)
        self._next = self._back + self._random.uniform(5, 120)
        self.count += 1
        return True

    def in_a_line(self) -> bool:
        """Whether that is in the middle of a line."""
        return self._random.random() < 0.5

    @property
    def out(self) -> bool:
        """Whether it is out."""
        return self.now() < self._back


class Unpluggable(Protocol):
    """A source that keeps what it gave and when."""

    outages: Outages
    given: list[Chunk]


class Unplugged:
    """A source that is out of its socket at times."""

    def __init__(self, inner: InstrumentSource, outages: Outages) -> None:
        self.inner, self.outages = inner, outages
        self.given: list[Chunk] = []

    def open(self) -> None:
        if self.outages.out:
            raise LinkLost(url="/dev/meter", problem=Text("unplugged", "отключён"))
        self.inner.open()

    def read(self) -> list[Chunk]:
        if self.outages.begins() and self.outages.in_a_line():
            half = Chunk(HALF, self.outages.now())
            self.given.append(half)
            self.inner.reset()
            return [half]
        if self.outages.out:
            raise LinkLost(url="/dev/meter", problem=Text("unplugged", "отключён"))
        found = self.inner.read()
        self.given += found
        return found

    def reset(self) -> None:
        self.inner.reset()

    def close(self) -> None:
        self.inner.close()


class Kept:
    """A source that is never out."""

    def __init__(self, inner: InstrumentSource) -> None:
        self.inner = inner
        self.given: list[Chunk] = []
        self.open, self.reset, self.close = inner.open, inner.reset, inner.close

    def read(self) -> list[Chunk]:
        found = self.inner.read()
        self.given += found
        return found


@dataclass
class Drive:
    """What was recorded and seen. `alone`: the recording of the same drive without instruments."""

    alone: Path
    path: Path
    meter: Unpluggable
    receiver: Kept
    samples: list[Sampled]

    @property
    def whole(self) -> set[float]:
        """The values of all lines that the meter sent whole."""
        sent = b"".join(b"\r\n" if it.data == HALF else it.data for it in self.meter.given)
        return {float(line) for line in sent.split() if line}


def drive_with_outages(
    folder: Path,
    meter_of: Callable[[InstrumentSource, ChosenInstrument, Outages], Unpluggable],
    *,
    rate: float = 2.0,
    alone_for: float = _HOUR,
) -> Drive:
    """Drive an hour with instruments, and `alone_for` seconds of it without; assert that the unit
    does not notice.
    """
    alone, path = folder / "alone.pcapng", folder / "beside.pcapng"
    with prepare(alone, (), duration=alone_for, rate=rate) as session:
        expected = session.run()
    with prepare(path, BOTH, duration=_HOUR, rate=rate) as session:
        port = session.acquisition.port
        chosen = session.instruments.chosen if session.instruments else ()
        meter = meter_of(VirtualSource(chosen[0], port), chosen[0], Outages(port.now, seed=5))
        receiver = Kept(VirtualSource(chosen[1], port))
        session.instruments = SessionInstruments(
            chosen, port, session.recorder, (CONNECTED, loss), sources=[meter, receiver]
        )
        changes: list[InstrumentChanged] = []
        session.on(InstrumentChanged, changes.append)
        samples: list[Sampled] = []
        session.on(Sampled, samples.append)
        session.run()
    drive = Drive(alone, path, meter, receiver, samples)
    # The unit: the same bytes at the same times, so the same rate.
    without, beside = unit_of(alone), unit_of(path)
    if alone_for == _HOUR:
        assert (len(samples), len(beside)) == (expected, len(without))
    assert len(without) > expected
    assert beside[: len(without)] == without
    # Nothing lost: every byte that came is in the file, with its time.
    packets = list(instrument_packets(path))
    for name, given in (("aem", meter.given), ("nmea", receiver.given)):
        own = [it for it in packets if label_and_name(it.source) == ("", name)]
        kept = [it for it in own if it.data]
        assert [it.data for it in kept] == [it.data for it in given]
        off = [abs(it.time - sent.time) for it, sent in zip(kept, given, strict=True)]
        assert max(off) < 2e-6
    count = meter.outages.count
    losses = [it.time for it in packets if loss_of(it) is not None]
    assert len(losses) == count, losses
    lost = [it for it in changes if it.name == "aem" and it.state is InstrumentState.LOST]
    assert len(lost) == count
    assert all(it.reason for it in lost)
    # Nothing mixed up: each value is one that was sent whole; the other one goes on.
    live = {it.instruments["AFR"].value for it in samples if "AFR" in it.instruments}
    assert live
    assert live <= drive.whole
    missing = sum("AFR" not in it.instruments for it in samples)
    assert 0.1 < missing / len(samples) < 0.9
    assert all("GPS_SPEED" in it.instruments for it in samples[10:])
    return drive
