"""The counts of one run, and its end: what `mikas log` shows and `mikas.session` counts."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

from mikas.errors import EngineStopped
from mikas.options import check_number
from mikas.sampling.events import CycleFailed, Event, LineState, Sampled, StateChanged, UnitFound

_SEARCH = 3  # failed cycles at the start that are no news: another method may follow
_ALIVE = (LineState.ECU_ALIVE, LineState.SAMPLING)


@dataclass(frozen=True, slots=True)
class Length:
    """How long a run lasts. Raises `UsageError`. None: without end.

    `duration`: from the first values on, also while none come. With a `rate`, no late sample is
    waited for at its end. `cycles`: failed cycles count as samples.
    """

    count: int | None = None
    """Samples."""
    duration: float | None = None
    """Seconds."""
    rate: float | None = None
    """Samples a second."""
    cycles: bool = False

    def __post_init__(self) -> None:
        if self.count is not None:
            check_number("count", self.count, lowest=0, whole=True)
        if self.duration is not None:
            check_number("duration", self.duration, lowest=0)

    @property
    def most(self) -> float:
        """The most samples."""
        most = inf if self.count is None else self.count
        if self.rate is None or self.duration is None:
            return most
        return min(most, int(self.rate * self.duration) + 1)


class RunProgress:
    """The counts of one run, by its events."""

    def __init__(self, length: Length) -> None:
        self._length = length
        self.samples: int = 0
        """The samples so far."""
        self.failed_cycles: int = 0
        """The cycles so far that gave no sample."""
        self.seconds: float = 0.0
        """The time from the first values to the latest event."""
        self.answered: bool = False
        """Whether a unit has answered."""
        self._began: float | None = None
        self._identified = False
        self._works = False  # sampled since the unit was identified
        self._searched = 0  # failed cycles before that

    def __repr__(self) -> str:
        return (
            f"<{type(self).__name__} {self.samples} samples in {self.seconds:.1f} s, "
            f"{self.failed_cycles} failed cycles>"
        )

    @property
    def rate(self) -> float:
        """Samples a second, on average."""
        return self.samples / self.seconds if self.seconds > 0 else 0.0

    @property
    def is_complete(self) -> bool:
        """Whether the run is over."""
        length = self._length
        counted = self.samples + (self.failed_cycles if length.cycles else 0)
        if counted >= length.most:
            return True
        is_timed = length.duration is not None and self._began is not None
        return is_timed and self.seconds >= (length.duration or 0.0)

    def is_searching(self, failed: CycleFailed) -> bool:
        """Return whether `failed` may be the refusal of a method, which is raised next."""
        if isinstance(failed.error, EngineStopped):
            return False
        self._searched += not self._works
        return not self._works and self._searched <= _SEARCH

    def follow(self, event: Event) -> None:
        """Count an event."""
        match event:
            case UnitFound():
                self._identified = True
            case StateChanged(state=state):
                self.answered |= state in _ALIVE
                if state is LineState.SAMPLING and self._began is None:
                    self._began = event.time
            case Sampled():
                self.samples += 1
                self._works |= self._identified
            case CycleFailed():
                self.failed_cycles += 1
            case _:
                pass
        if self._began is not None:
            self.seconds = max(self.seconds, event.time - self._began)
