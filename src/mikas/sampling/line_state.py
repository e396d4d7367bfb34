"""The state of the line to the unit: one table of all transitions.

    every state ── PORT_LOST ─► NO_PORT           every state ── ECHO_MISSING ───► NO_ECHO
    every state ── ENDED ─────► not running       every state ── SILENT, SPOILT ─► ECHO_ONLY

    not running, NO_PORT, NO_ECHO ── PORT_MISSING ─► NO_PORT
    not running, NO_PORT, NO_ECHO, ECHO_ONLY ── IDENTIFIED ─► ECU_ALIVE ── ACCEPTED ─► SAMPLING
                                                                  ▲                       │
                                                                  └─────── REFUSED ───────┘

A connection over a network that fell silent is opened again without leaving NO_ECHO, so from there
a port may be missing.

An event without a cell in the present state's row of `TRANSITIONS` cannot occur there: a bug of the
caller, and `ImpossibleTransition` is raised. The table knows no port, clock or unit; `supervisor`
and `acquisition` observe these and report the events.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import Final

from mikas.errors import EchoOnly, LineError, NoConnection
from mikas.sampling.events import LineState


class LineTrigger(Enum):
    """An observation that may change the state."""

    PORT_MISSING = "the port could not be opened"
    PORT_LOST = "the open port failed: the adapter was unplugged"
    ECHO_MISSING = "a request was not even echoed: no 12 V at the adapter, or a silent network"
    SILENT = "a request was echoed and not answered: the ignition is off"
    SPOILT = "responses are damaged, out of step, or of another unit"
    IDENTIFIED = (
        "a unit answered and gave its version; and its passport, if another was read before"
    )
    ACCEPTED = "the unit gives requested parameters"
    REFUSED = "the unit refuses every requested parameter, or every method"
    ENDED = "sampling was stopped, or an error ended it"


class ImpossibleTransition(RuntimeError):
    """A bug: the event cannot occur in the state."""


_ALWAYS: Final[Mapping[LineTrigger, LineState | None]] = {
    LineTrigger.PORT_LOST: LineState.NO_PORT,  # also of a port that failed at its first use
    LineTrigger.ECHO_MISSING: LineState.NO_ECHO,
    LineTrigger.SILENT: LineState.ECHO_ONLY,
    LineTrigger.SPOILT: LineState.ECHO_ONLY,
    LineTrigger.ENDED: None,
}
_UNOPENED: Final = {LineTrigger.PORT_MISSING: LineState.NO_PORT}
_UNSAMPLED: Final = {LineTrigger.IDENTIFIED: LineState.ECU_ALIVE}
_ANSWERING: Final = {
    LineTrigger.ACCEPTED: LineState.SAMPLING,  # while sampling: another plan
    LineTrigger.REFUSED: LineState.ECU_ALIVE,
}
TRANSITIONS: Final[Mapping[LineState | None, Mapping[LineTrigger, LineState | None]]] = {
    None: {**_ALWAYS, **_UNOPENED, **_UNSAMPLED},  # not running
    LineState.NO_PORT: {**_ALWAYS, **_UNOPENED, **_UNSAMPLED},
    LineState.NO_ECHO: {**_ALWAYS, **_UNOPENED, **_UNSAMPLED},
    LineState.ECHO_ONLY: {**_ALWAYS, **_UNSAMPLED},
    LineState.ECU_ALIVE: {**_ALWAYS, **_UNSAMPLED, **_ANSWERING},  # identified: another unit
    LineState.SAMPLING: {**_ALWAYS, **_ANSWERING},
}


def trigger_of(error: NoConnection | LineError) -> LineTrigger:
    """Return the event of a request that failed with `error`; a lost port is none."""
    match error:
        case EchoOnly():
            return LineTrigger.SILENT
        case NoConnection():
            return LineTrigger.ECHO_MISSING
        case LineError():
            return LineTrigger.SPOILT


def following(state: LineState | None, event: LineTrigger) -> LineState | None:
    """Return the state after `event` in `state`. Raises `ImpossibleTransition`."""
    row = TRANSITIONS[state]
    if event not in row:
        name = state.name if state else "None"
        raise ImpossibleTransition(f"{event.name} cannot occur in state {name}")
    return row[event]
