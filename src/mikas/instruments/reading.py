"""One instrument of a session: its bytes recorded as they came, its values, its connection.

    source ──► InstrumentReader.poll ──► sink (the recorder)
                     │ decoder ──► the last values, with their times
                     └ changes: connected, silent, giving values, lost

A loss is tried again after a second, then two, four, five. A program that did not run for a while
loses what came meanwhile, not the connection. Nothing here knows the unit's line.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Final, NamedTuple, Protocol

from mikas.catalog.instrument_channels import InstrumentChannel
from mikas.errors import MikasError, ReadingSuspended
from mikas.i18n import Text
from mikas.instruments.choosing import ChosenInstrument, line_baud
from mikas.instruments.decoding import decoder_of
from mikas.instruments.events import NO_FIX, InstrumentValues
from mikas.instruments.sources import InstrumentSource
from mikas.instruments.timing import TimedInstrumentDecoder
from mikas.link.base import BITS_PER_BYTE

_FIRST_RETRY: Final = 1.0  # s
_LONGEST_RETRY: Final = 5.0
_LASTING: Final = 5.0  # s of a connection with values, after which a loss is a new one
_SILENT: Final = 3.0  # s without a value, at least
_KEPT: Final = 512  # messages: of a receiver those of some ten seconds


class InstrumentState(StrEnum):
    """The state of an instrument's connection."""

    CONNECTED = "connected"
    VALUES = "values"
    SILENT = "silent"
    LOST = "lost"


@dataclass(frozen=True, slots=True)
class InstrumentChange:
    """A new state of an instrument. `reason`: why it is lost, or gives no values."""

    time: float
    """When, on the session's clock."""
    chosen: ChosenInstrument
    """Which one."""
    state: InstrumentState
    """The new state."""
    reason: Text | None = None


class InstrumentSink(Protocol):
    """The receiver of the bytes: a recorder."""

    def record_instrument(self, number: int, data: bytes, time: float, comment: str = "") -> None:
        """Record bytes, or by a comment the begin or the end of a connection."""


@dataclass(frozen=True, slots=True)
class InstrumentReading:
    """A value of an instrument."""

    channel: InstrumentChannel
    """Its channel, with the label in its name."""
    value: float
    """The value, in the channel's unit."""
    time: float
    """When its last byte came, on the session's clock."""

    @property
    def name(self) -> str:
        """The channel's name."""
        return self.channel.name

    @property
    def unit(self) -> str:
        """The key of the unit."""
        return self.channel.unit


class _Message(NamedTuple):
    """Its time and values, by the channels' names; None: a loss."""

    time: float
    readings: Mapping[str, InstrumentReading] | None


class InstrumentReader:
    """Reads the instrument `chosen` from `source`; `number`: its place among the recorder's.

    `clock`: the session's. `report`: gets the changes of the connection. `comments`: of a begin and
    of a loss, as the recorder writes them. One thread calls `poll`; any thread may call `fresh`.
    """

    def __init__(
        self,
        number: int,
        chosen: ChosenInstrument,
        source: InstrumentSource,
        sink: InstrumentSink,
        *,
        clock: Callable[[], float],
        report: Callable[[InstrumentChange], None],
        comments: tuple[str, Callable[[Text], str]],
    ) -> None:
        self.chosen = chosen
        self._number, self._source, self._sink, self._report = number, source, sink, report
        self._clock = clock
        self._begin_comment, self._loss_comment = comments
        definition = chosen.definition
        plain = (channel.name for channel in definition.channels)
        self._channels = dict(zip(plain, chosen.channels, strict=True))
        self._decoder = TimedInstrumentDecoder(
            decoder_of(definition), BITS_PER_BYTE / line_baud(definition, chosen.url)
        )
        self._recent: deque[_Message] = deque(maxlen=_KEPT)
        self._lock = threading.Lock()
        self.latest: InstrumentChange | None = None
        """The change reported last, with the state now; None before the first."""
        self.damaged: int = 0
        """The messages that gave no value, since the session began."""
        self._retry, self._due = _FIRST_RETRY, float("-inf")
        self._opened = 0.0
        self._valued = 0.0  # when it last gave a value, or was connected
        self._why: Text | None = None  # the reason of the last bytes without a value
        self._is_open = False
        self._closed = False

    @property
    def state(self) -> InstrumentState | None:
        """The state reported last; None before the first."""
        return self.latest.state if self.latest else None

    def poll(self) -> bool:
        """Take what has come; return whether it is connected."""
        try:
            if not self._is_open:
                if self._clock() < self._due:
                    return False
                self._source.open()
                self._is_open = True
                now = self._valued = self._opened = self._clock()
                self._begin(now)
                self._change(now, InstrumentState.CONNECTED)
            for data, time in self._source.read():
                self._take(data, time)
        except MikasError as error:
            now = self._clock()
            if not (self._is_open and isinstance(error, ReadingSuspended)):
                self._lose(now, error)
                return False
            self._leave_out(now, error)
            self._begin(now)
        now = self._clock()
        limit = max(_SILENT, 2 * self.chosen.definition.stale)
        if now - self._valued > limit and self.state is not InstrumentState.SILENT:
            self._change(now, InstrumentState.SILENT, self._why or _NOTHING)
        return True

    def fresh(self, time: float) -> Mapping[str, InstrumentReading]:
        """Return the values that hold at `time`, by the channels' names.

        They are the last ones before it, as in a recording that is read again: not what has come
        since, nor what came before a loss. Of an instrument so quick that all it kept has come
        since, the first ones.
        """
        found: dict[str, InstrumentReading] = {}
        with self._lock:
            recent = self._recent
            if len(recent) == _KEPT:
                time = max(time, recent[0].time)
            for each in reversed(recent):
                if each.time > time:
                    continue
                if each.readings is None or time - each.time > self.chosen.definition.stale:
                    break
                found = {**each.readings, **found}
                if len(found) == len(self._channels):
                    break
        return found

    def close(self) -> None:
        """Close the source; any thread may call."""
        self._closed = True
        self._source.close()

    def _begin(self, now: float) -> None:
        self._decoder.drop()
        self._sink.record_instrument(self._number, b"", now, self._begin_comment)

    def _leave_out(self, now: float, error: MikasError) -> None:
        """What comes from here on follows nothing of what came before."""
        self._keep(_Message(now, None))
        self._sink.record_instrument(self._number, b"", now, self._loss_comment(error.reason))

    def _take(self, data: bytes, time: float) -> None:
        self._sink.record_instrument(self._number, data, time)
        for event, at in self._decoder.feed(data, time):
            if not isinstance(event, InstrumentValues):
                self._why = event.reason
                self.damaged += event.reason != NO_FIX
                continue
            channels = self._channels
            readings = [
                InstrumentReading(channels[it], value, at) for it, value in event.values.items()
            ]
            self._keep(_Message(at, {each.name: each for each in readings}))
            self._valued, self._why = time, None
            if self.state is not InstrumentState.VALUES:
                self._change(time, InstrumentState.VALUES)

    def _lose(self, now: float, error: MikasError) -> None:
        was_open, self._is_open = self._is_open, False
        if self._closed:  # the session ends, which is no loss
            return
        self._source.reset()
        if was_open:
            self._leave_out(now, error)
        if was_open and self._valued > self._opened and now - self._opened > _LASTING:
            self._retry = _FIRST_RETRY
        self._due = now + self._retry
        self._retry = min(2 * self._retry, _LONGEST_RETRY)
        if self.state is not InstrumentState.LOST:
            self._change(now, InstrumentState.LOST, error.reason)

    def _keep(self, message: _Message) -> None:
        with self._lock:
            self._recent.append(message)

    def _change(self, time: float, state: InstrumentState, reason: Text | None = None) -> None:
        self.latest = InstrumentChange(time, self.chosen, state, reason)
        self._report(self.latest)


_NOTHING: Final = Text("nothing comes", "ничего не приходит")
