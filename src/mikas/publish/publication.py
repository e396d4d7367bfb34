"""The messages of one session, made of its events. No network, and no clock but the events' times.

When the computer's date was set, messages have the new date from then on, and those that the broker
keeps are made again.

Values come at their first sample, then in each interval, and at once when the line breaks: all of
them None then. State, unit, faults and alarms come when they change; the broker keeps them.
`current` of faults and alarms says whether they are of a unit that answers now.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

from mikas.catalog import Catalog, Derived, InstrumentChannel, Parameter
from mikas.client.parameters.polling import next_due
from mikas.i18n import Text
from mikas.json_values import picked
from mikas.publish.outbox import Message, MessageKind, compact, json_payload, rounded
from mikas.publish.topics import Topics
from mikas.publish.values import LatestValues, SampleBatch, plain_values, unit_of
from mikas.sampling import events
from mikas.sampling.events import Event
from mikas.sampling.instrument_changes import InstrumentChanged

_NO_ALARM: Final = "none"
STATES: Final = {
    "starting": Text("looking for the unit", "поиск блока"),
    "stopped": Text("not running", "опрос не идёт"),
}
"""The states before the first one of the line and after the last."""


@dataclass(eq=False)
class Publication:
    """Makes the messages of one session of `channels` under `topics`.

    `every`: seconds between two messages of values. `qos`: of values. `each`: each value under a
    topic of its own, too. `samples`: every sample, too. `interpretation`: by which the values are
    decoded.
    """

    topics: Topics
    catalog: Catalog
    channels: Sequence[Parameter | Derived | InstrumentChannel]
    every: float = 1.0
    qos: int = 0
    each: bool = False
    samples: bool = False
    interpretation: str = "corrected"

    def __post_init__(self) -> None:
        names = [channel.name for channel in self.channels]
        beside = (each.name for each in self.channels if isinstance(each, InstrumentChannel))
        self._latest = LatestValues(names, beside)
        self._batch = SampleBatch(self.topics.samples, names, max(1, self.qos))
        self._gaps: list[events.Gap] = []  # those that the next event begins or ends
        self._due: float | None = None  # of the next values
        self._reason: Text | None = None  # of the latest failed cycle
        self._answers = False  # whether values come
        self._faults: events.FaultReading | None = None  # as read last
        self._faults_current = False
        self._told: tuple[int, ...] | None = None  # the faults of the latest event
        self._alarms: dict[str, events.AlarmChanged] = {}  # the present ones
        self._state: tuple[float | None, dict[str, Any]] = (None, {})  # the latest, and its time
        self._unit: events.UnitFound | None = None
        self._later = 0.0  # seconds that the date is later than the events' clock

    def begin(self) -> list[Message]:
        """Return the messages before the first event: nothing is known yet."""
        return [
            self._channel_message(),
            self._fault_message(None),
            self._alarm_message(None),
            self._own_state("starting", None),
        ]

    def last_messages(self, time: float | None = None) -> list[Message]:
        """Return the messages after the last event."""
        return [*self._batch.messages(self._later), self._own_state("stopped", time)]

    def messages_of(self, event: Event) -> list[Message]:
        """Return the messages of `event`; a gap's follow with those of the event after it."""
        if isinstance(event, events.Gap):
            self._gaps.append(event)
            return []
        return [*self._of(event), *self._happened(event), *self._values(event)]

    # State, unit, faults, alarms

    def _of(self, event: Event) -> Iterator[Message]:
        match event:
            case events.Sampled():
                values = plain_values(event)
                ages = {name: event.time - it.time for name, it in event.instruments.items()}
                self._latest.add_sample(event.time, values, ages)
                if self.samples:
                    self._batch.add_row(event.time, values)
                if not self._answers:
                    self._answers, self._due = True, None
                    yield self._alarm_message(event.time)
            case events.CycleFailed(error=error):
                self._reason = error.reason
            case events.StateChanged():
                yield from self._state_changed(event)
            case events.UnitFound():
                yield from self._unit_found(event)
            case events.FaultReading():
                self._faults, self._faults_current = event, True
                yield self._fault_message(event.time)
            case events.AlarmChanged():
                self._alarms.pop(event.name, None)
                if event.level != _NO_ALARM:
                    self._alarms[event.name] = event
                yield self._alarm_message(event.time)
            case events.ParameterDropped(name=name) if self._alarms.pop(name, None):
                yield self._alarm_message(event.time)
            case events.ClockChanged(later=later) if later:
                self._later += later
                yield from self._kept(event.time)

    def _state_changed(self, event: events.StateChanged) -> Iterator[Message]:
        state = event.as_json()
        del state["kind"]
        state["code"] = type(event.error).__name__ if event.error else None
        yield self._state_message(event.time, state)
        if not event.is_broken:
            return
        self._reason = event.reason or event.text
        self._latest.clear()
        if self._answers:
            self._answers, self._due = False, None
            yield self._alarm_message(event.time)
        if self._faults_current:
            self._faults_current = False
            yield self._fault_message(event.time)

    def _unit_found(self, event: events.UnitFound) -> Iterator[Message]:
        self._unit = event
        yield self._unit_message(event)
        if event.another:
            self._latest.clear()
            self._alarms.clear()
            self._faults = self._told = None
            self._faults_current = False
            yield self._fault_message(event.time)
            yield self._alarm_message(event.time)

    def _kept(self, time: float) -> Iterator[Message]:
        """Yield the messages that the broker keeps and that have times."""
        yield self._state_message(*self._state)
        if self._unit is not None:
            yield self._unit_message(self._unit)
        yield self._fault_message(time)
        yield self._alarm_message(time)

    def _unit_message(self, event: events.UnitFound) -> Message:
        unit = event.as_json() | {"time": self._date(event.time)}
        del unit["kind"]
        return self._message(self.topics.unit, unit, event.time)

    def _state_message(self, time: float | None, state: dict[str, Any]) -> Message:
        self._state = time, state
        whole = {"time": self._date(time), "reason": None, "code": None}
        whole |= {key: value for key, value in state.items() if key != "time"}
        return self._message(self.topics.state, whole, time)

    def _own_state(self, name: str, time: float | None) -> Message:
        return self._state_message(time, {"state": name, "text": STATES[name]._asdict()})

    def _channel_message(self) -> Message:
        channels = [
            {
                "name": channel.name,
                "unit": unit_of(channel, self.interpretation)[0],
                "text": channel.text._asdict(),
                "flag": channel.is_flag,
            }
            for channel in self.channels
        ]
        return self._message(self.topics.channels, {"channels": channels}, None)

    def _fault_message(self, time: float | None) -> Message:
        content: dict[str, Any] = {"time": None, "current": self._faults_current}
        content |= {"count": None, "faults": None}
        if (read := self._faults) is not None:
            stored = [self.catalog.fault(code).as_json() for code in read.codes]
            content |= {"time": self._date(read.time), "count": len(stored), "faults": stored}
        return self._message(self.topics.faults, content, time)

    def _alarm_message(self, time: float | None) -> Message:
        present = [
            {
                **picked(alarm, "name", "level", "side", "limit"),
                "since": self._date(alarm.time),
                "text": alarm.text._asdict(),
            }
            for alarm in self._alarms.values()
        ]
        content = {
            "time": self._date(time),
            "current": self._answers,
            "count": len(present),
            "alarms": present,
        }
        return self._message(self.topics.alarms, content, time)

    def _message(self, topic: str, content: dict[str, Any], time: float | None) -> Message:
        date = self._date(time)
        return Message(topic, json_payload(content), MessageKind.RETAINED, time=date)

    def _date(self, time: float | None) -> float | None:
        return None if time is None else rounded(time + self._later)

    # What happened

    def _happened(self, event: Event) -> Iterator[Message]:
        happened: list[Event] = [*self._gaps]
        self._gaps.clear()
        match event:
            case events.FaultReading(codes=codes) if codes != self._told:
                before, self._told = self._told, codes
                new = None if before is None else tuple(it for it in codes if it not in before)
                happened.append(replace(event, added=new))
            case events.StateChanged() | events.UnitFound() | events.AdapterMoved():
                happened.append(event)
            case events.ParameterDropped() | events.ParameterReturned() | InstrumentChanged():
                happened.append(event)
            case events.MethodChosen() | events.AlarmChanged() | events.ClockChanged():
                happened.append(event)
        for each in happened:
            dated = each.moved(self._later)
            content = {**dated.as_json(), "time": rounded(dated.time)}
            if isinstance(each, events.MethodChosen):
                content["rates"] = {name: round(rate, 2) for name, rate in each.rates.items()}
            topic, payload = self.topics.event, json_payload(content)
            yield Message(topic, payload, MessageKind.EVENT, time=rounded(dated.time))

    # Values

    def _values(self, event: Event) -> Iterator[Message]:
        broken = isinstance(event, events.StateChanged) and event.is_broken
        if not (broken or isinstance(event, events.Sampled | events.CycleFailed)):
            return
        time = event.time
        if self._due is None or time >= self._due:
            self._due = next_due(time if self._due is None else self._due, time, self.every)
            yield from self._latest_values(time)
            yield from self._batch.messages(self._later)
        elif self._batch.is_full:
            yield from self._batch.messages(self._later)

    def _latest_values(self, time: float) -> Iterator[Message]:
        latest, qos, date = self._latest.at(time), self.qos, self._date(time)
        content: dict[str, Any] = {
            "time": date,
            "values": latest.values,
            "ages": latest.ages,
            "gap": latest.is_gap,
        }
        if latest.is_gap and self._reason is not None:
            content["reason"] = self._reason._asdict()
        yield Message(self.topics.values, json_payload(content), MessageKind.LIVE, qos, date)
        if self.each:
            for name, value in latest.values.items():
                yield Message(self.topics.value(name), compact(value), MessageKind.LIVE, qos, date)
