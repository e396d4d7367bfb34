"""The recorded car of a virtual ECU.

A datum holds until the next recorded one; before the first, the first holds. The ECU is silent
where the recording shows a loss of supply or has a hole, and after its end; it refuses a parameter
where the recorded one did. Nothing is invented: a parameter, a passport or a memory space that was
never read is not answered, and a write is accepted only if the recorded ECU accepted one to the
same parameter.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from dataclasses import dataclass
from math import ceil, floor, inf
from typing import Final

from mikas.catalog import Catalog
from mikas.errors import MikasError
from mikas.link.base import BITS_PER_BYTE
from mikas.replay.model import ReplayData
from mikas.virtual.responder import Identity

UNKNOWN_VERSION: Final = 0xFF
_STROKES_APART: Final = 2.0  # s; a longer pause between recorded strokes is no stream
_ROUNDING: Final = 0.0001  # s


@dataclass(frozen=True, slots=True)
class _Playing:
    """The recording is at second `position` at `now` of the owner's clock, and plays at `speed`."""

    now: float
    position: float
    speed: float


class ReplayCar:
    """Data from a recording; implements `mikas.virtual.responder.Car`.

    With the first byte of a request the recording is at second `seek`. `speed`: of the car, not of
    the wire; 0 holds it. `loop`: restart at the end.
    """

    def __init__(
        self,
        recorded: ReplayData,
        catalog: Catalog,
        *,
        seek: float = 0.0,
        speed: float = 1.0,
        loop: bool = False,
    ) -> None:
        self.recorded = recorded
        self.codes: tuple[int, ...] = tuple(recorded.places)
        self.loop = loop
        self.speed: float = speed
        self._catalog = catalog
        self._waiting = True
        self._now = 0.0
        self._playing = _Playing(0.0, seek, 0.0)
        self._written: dict[int, bytes] = {}
        self._faults: list[int] = []
        self._faults_index: int | None = None  # of the recorded list that `_faults` was
        self._stroke_at: dict[int, float] = {}
        edges = {
            edge for quiet in (recorded.silences, recorded.holes) for it in quiet for edge in it
        }
        self._edges = sorted({*edges, recorded.duration} - {0.0})

    # Position

    @property
    def duration(self) -> float:
        """The seconds from the recording's begin to its end."""
        return self.recorded.duration

    def position(self, now: float | None = None) -> float:
        """Return the second of the recording at `now`; by default at the latest known time."""
        return self._in_lap(self._unrolled(self._now if now is None else now))

    def seek(self, seconds: float, now: float | None = None) -> None:
        """Go to this second of the recording. Callable from any thread."""
        now = self._now if now is None else now
        self._playing = _Playing(now, max(0.0, seconds), self._playing.speed)
        self._stroke_at.clear()

    def set_speed(self, speed: float, now: float | None = None) -> None:
        """Continue at this speed; 0 holds the car."""
        if not 0 <= speed < inf:
            raise ValueError("the speed is 0 or more")
        now = self._now if now is None else now
        self.speed = speed
        if not self._waiting:
            self._playing = _Playing(now, self._unrolled(now), speed)

    def _unrolled(self, now: float) -> float:
        """Return the position, all laps included."""
        playing = self._playing
        return playing.position + (now - playing.now) * playing.speed

    def _in_lap(self, unrolled: float) -> float:
        if self.loop and self.duration > 0:
            return unrolled % self.duration
        return min(unrolled, self.duration)

    def _when(self, unrolled: float) -> float:
        """Return when the position is reached; infinity while the car is held."""
        playing = self._playing
        if not playing.speed or unrolled == inf:
            return inf
        return playing.now + (unrolled - playing.position) / playing.speed

    def look(self, now: float) -> None:
        """Set the time of the owner's clock."""
        self._now = now

    # For the responder

    @property
    def faults(self) -> list[int]:
        """The last recorded faults; an erasure holds until the next recorded list."""
        faults = self.recorded.faults
        index = faults.index(self.position())
        if faults.values and index != self._faults_index:
            self._faults_index = index
            self._faults = list(faults.values[index])
        return self._faults

    @faults.setter
    def faults(self, faults: list[int]) -> None:
        self._faults = faults

    def identity(self) -> Identity:
        """Return the identity of the recorded ECU."""
        position = self.position()
        recorded = self.recorded
        version = recorded.version.at(position)
        return Identity(
            UNKNOWN_VERSION if version is None else version,
            tuple(passport.at(position) or "" for passport in recorded.passports),
            recorded.count.at(position),
        )

    def size_of(self, code: int) -> int | None:
        """Return the bytes of the datum; None: never recorded, or refused at this position."""
        return self.recorded.size_of(code, self.position())

    def raw(self, code: int, now: float) -> bytes:
        """Return the latest recorded datum."""
        written = self._written.get(code)
        return self._recorded(code, self.position(now)) if written is None else written

    def _recorded(self, code: int, position: float) -> bytes:
        places = self.recorded.places[code]
        latest, when = None, -inf
        for series, begin, size in places:
            index = bisect_right(series.times, position) - 1
            if index >= 0 and series.times[index] >= when:
                latest, when = (series, index, begin, size), series.times[index]
        if latest is None:
            series, begin, size = min(places, key=lambda place: place[0].times[0])
            latest = series, 0, begin, size
        series, index, begin, size = latest
        return series.datum(index, begin, size)

    def write(self, code: int, data: bytes) -> bool:
        """Accept the value until the next power cycle, if the recorded ECU accepted one."""
        if code not in self.recorded.writable:
            return False
        self._written[code] = data
        return True

    def engine_speed(self, now: float) -> float:  # noqa: ARG002  (unknown at any time)
        """Return 0: the recorded gap between responses has the load in it (D16)."""
        return 0.0

    def powered(self, now: float) -> bool:
        """Return whether the recorded ECU had its supply, and the line was recorded."""
        if self._waiting:
            self._waiting = False
            byte_time = BITS_PER_BYTE / self.recorded.baud
            self._playing = _Playing(now - byte_time, self._playing.position, self.speed)
        self._now = now
        if self.is_over(now):
            return False
        return self.recorded.is_audible(self._in_lap(self._unrolled(now)))

    def is_over(self, now: float) -> bool:
        """Return whether the recording has been played to its end at `now`."""
        return not self.loop and self._unrolled(now) >= self.duration

    def next_change(self, after: float) -> float:
        """Return when a silence begins or ends next, or the recording ends; infinity: it waits."""
        if not self._playing.speed:
            return inf
        unrolled = self._unrolled(max(after, self._playing.now))
        lap = floor(unrolled / self.duration) if self.loop and self.duration > 0 else 0
        position = unrolled - lap * self.duration
        index = bisect_right(self._edges, position)
        if index < len(self._edges):
            return self._when(lap * self.duration + self._edges[index])
        return self._when((lap + 1) * self.duration + self._edges[0]) if self.loop else inf

    def next_stroke(self, stroke: int, after: float) -> float:
        """Return the next recorded stroke; without one, that of the recorded engine speed."""
        unrolled = self._unrolled(after)
        position = self._in_lap(unrolled)
        strokes = self.recorded.strokes.get(stroke)
        if strokes:
            index = bisect_left(strokes, position - _ROUNDING)
            if index < len(strokes) and strokes[index] - position < _STROKES_APART:
                return max(after, self._when(unrolled + strokes[index] - position))
        cycle = self._cycle(position)
        if cycle is None:
            return inf
        offset = max(0, stroke - 1) * cycle / 4
        known = self._stroke_at.get(stroke, offset)
        count = ceil((unrolled - known) / cycle - 1e-9)
        self._stroke_at[stroke] = known + count * cycle
        return max(after, self._when(self._stroke_at[stroke]))

    def _cycle(self, position: float) -> float | None:
        """Return the seconds of two turns (D15); None: engine stopped, or its speed unknown."""
        for name in ("FREQ", "FREQX"):
            try:
                parameter = self._catalog.parameter(name)
                if self.size_of(parameter.code) == parameter.size:
                    rpm = float(parameter.decode(self._recorded(parameter.code, position)))
                    return 120 / rpm if rpm > 0 else None
            except MikasError:  # a catalog without it
                continue
        return None

    def silences_past(self) -> int:
        """Return how many silences of the recording lie before the present position."""
        return bisect_right(self.recorded.silences, self.position(), key=lambda silence: silence[1])

    def power_cycle(self) -> None:
        """Forget the written data."""
        self._written.clear()
