"""The states of the line to the ECU, and their words."""

from __future__ import annotations

from enum import StrEnum
from typing import Final

from mikas.errors import PortKind
from mikas.i18n import Text


class LineState(StrEnum):
    """The state of the line to the ECU, from worst to best."""

    NO_PORT = "no-port"
    """No adapter, or no connection to its bridge."""
    NO_ECHO = "no-echo"
    """Not even the echo comes back: no supply, or another port."""
    ECHO_ONLY = "echo-only"
    """The line is there, the ECU is silent."""
    ECU_ALIVE = "ecu-alive"
    """The ECU answers."""
    SAMPLING = "sampling"
    """Values come."""

    @property
    def text(self) -> Text:
        """The state in words, at a cable."""
        return _WORDS[self]

    def text_on(self, kind: PortKind) -> Text:
        """Return the state in words, on a port of this kind."""
        return _OVER_NETWORK.get(self, self.text) if kind is PortKind.NETWORK else self.text


_WORDS: Final = {
    LineState.NO_PORT: Text("no adapter", "нет адаптера"),
    LineState.NO_ECHO: Text(
        "no echo: no 12 V at the adapter, or the wrong port",
        "нет эха: на адаптере нет 12 В или не тот порт",
    ),
    LineState.ECHO_ONLY: Text(
        "echo, but the ECU is silent: ignition off?",
        "эхо есть, блок молчит: выключено зажигание?",
    ),
    LineState.ECU_ALIVE: Text("the ECU answers", "блок отвечает"),
    LineState.SAMPLING: Text("sampling", "идёт опрос"),
}
_OVER_NETWORK: Final = {
    LineState.NO_PORT: Text("no connection to the bridge", "нет связи с мостом"),
    LineState.NO_ECHO: Text(
        "no echo: the bridge is silent, its Wi-Fi or its supply?",
        "нет эха: мост молчит, его Wi-Fi или питание?",
    ),
    LineState.ECHO_ONLY: Text(
        "echo, but the ECU is silent: ignition off, or the bridge's baud rate?",
        "эхо есть, блок молчит: выключено зажигание или скорость порта моста?",
    ),
}
STATE_TEXTS: Final = tuple(
    dict.fromkeys(state.text_on(kind) for kind in PortKind for state in LineState)
)
"""All words that `StateChanged.text` may be."""
