"""What happened beside the values, for the formats that have a place for it: markers, notes, gaps,
alarms. Times count from the file's zero, as the rows' do.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

from mikas.i18n import Text
from mikas.sampling.events import AlarmChanged, Event, Gap, Marker, TextNote

_MARKER = Text("marker", "отметка")
_NO_REASON = Text("nothing came", "ничего не пришло")


@dataclass(frozen=True, slots=True)
class Moment:
    """`kind`: marker, note, gap or alarm. `ended`: of a gap, None if it lasted to the end.

    `facts`: what an alarm was about, by name, for a reader that is a program.
    """

    kind: str
    time: float
    text: Text
    ended: float | None = None
    facts: dict[str, Any] = field(default_factory=dict)

    def as_json(self) -> dict[str, Any]:
        """As it stands in a file's metadata."""
        told: dict[str, Any] = {"kind": self.kind, "time": round(self.time, 6)}
        if self.kind == Gap.kind:
            told["ended"] = None if self.ended is None else round(self.ended, 6)
        return told | self.facts | {"en": self.text.en, "ru": self.text.ru}


def moments_of(events: Iterable[Event], zero: float) -> tuple[Moment, ...]:
    """Those of `events` that exports tell, in the order of their times."""
    return tuple(sorted(_moments(events, zero), key=lambda moment: moment.time))


def began(event: Event) -> float:
    """When it was so first, on the link's clock; a gap is noted when it has ended."""
    return event.began if isinstance(event, Gap) else event.time


def _moments(events: Iterable[Event], zero: float) -> Iterator[Moment]:
    for event in events:
        time = began(event) - zero
        match event:
            case Marker():
                text = _line(Text(event.label, event.label))
                yield Moment(event.kind, time, text if text.en else _MARKER)
            case TextNote():
                yield Moment(event.kind, time, _line(Text(event.text, event.text)))
            case Gap():
                ended = None if event.ended is None else event.ended - zero
                yield Moment(event.kind, time, _gap(event, time, ended), ended)
            case AlarmChanged():
                text = event.text if event.text.en else Text(*[f"{event.name}: {event.level}"] * 2)
                facts = {
                    name: getattr(event, name)
                    for name in ("name", "level", "before", "side", "value", "limit")
                }
                yield Moment(event.kind, time, _line(text), facts=facts)


def _gap(event: Gap, time: float, ended: float | None) -> Text:
    reason = _line(event.reason or _NO_REASON)
    if ended is None:
        return Text(f"gap to the end: {reason.en}", f"разрыв до конца: {reason.ru}")
    seconds = f"{ended - time:.1f}"
    return Text(
        f"gap of {seconds} s: {reason.en}",
        f"разрыв {seconds.replace('.', ',')} с: {reason.ru}",
    )


def _line(text: Text) -> Text:
    return Text(*(" ".join(each.split()) for each in text))
