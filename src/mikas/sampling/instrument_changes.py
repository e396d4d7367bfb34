"""The event of an instrument beside the unit: found, silent, lost.

A recording has no note of it: the instrument's own packets say when its connection began and ended.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from mikas.cleaning import public_port
from mikas.i18n import Text
from mikas.instruments.reading import InstrumentChange, InstrumentState
from mikas.sampling.events import Event


@dataclass(frozen=True, slots=True)
class InstrumentChanged(Event):
    """An instrument has another state. `reason`: why it is lost, or gives no values."""

    kind = "instrument"
    name: str
    """The instrument, with its label: `left:aem`."""
    state: InstrumentState
    """The new state."""
    text: Text
    """The state in words."""
    reason: Text | None = None

    @classmethod
    def of(cls, change: InstrumentChange) -> InstrumentChanged:
        """Return the event of a change."""
        name = change.chosen.title
        port, why = public_port(change.chosen.url), change.reason or _UNKNOWN
        text = _TEXTS[change.state].filled(name=name, port=port, why=why)
        return cls(change.time, name, change.state, text, change.reason)


_UNKNOWN: Final = Text("the reason is not known", "причина неизвестна")
_TEXTS: Final = {
    InstrumentState.CONNECTED: Text(
        "the instrument {name} is connected at {port}", "прибор {name} подключён к {port}"
    ),
    InstrumentState.VALUES: Text(
        "the instrument {name} gives values", "прибор {name} даёт значения"
    ),
    InstrumentState.SILENT: Text(
        "the instrument {name} gives no values ({why}); check its wire and its speed (baud)",
        "прибор {name} не даёт значений ({why}); проверьте провод и скорость порта (baud)",
    ),
    InstrumentState.LOST: Text(
        "the instrument {name} is not there ({why}); it is tried again, and sampling goes on",
        "прибора {name} нет ({why}); попытки продолжаются, опрос блока идёт дальше",
    ),
}
