"""The state of the line to the unit: one table of all transitions.

    every state ── PORT_LOST ─► NO_PORT           every state ── ECHO_MISSING ───► NO_ECHO
    every state ── ENDED ─────► not running       every state ── SILENT, SPOILT ─► ECHO_ONLY

    not running ── PORT_MISSING ─► NO_PORT ─┐
    not running, NO_ECHO, ECHO_ONLY ────────┴─ IDENTIFIED ─► ECU_ALIVE ── ACCEPTED ─► SAMPLING
                                                                 ▲                       │
                                                                 └─────── REFUSED ───────┘

An event without a cell in the present state's row of `TRANSITIONS` cannot occur there: a bug of the
caller, and `ImpossibleTransition` is raised. The machine has no port, clock or unit; `supervisor`
and `acquisition` observe these and report the events.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import Final

from mikas.errors import EchoOnly, LineError, MikasError, NoConnection
from mikas.sampling.events import LineState


class LineTrigger(Enum):
    """An observation that may change the state."""

    PORT_MISSING = "the port could not be opened"
    PORT_LOST = "the open port failed: the adapter was unplugged"
    ECHO_MISSING = "a request was not even echoed: no 12 V at the adapter"
    SILENT = "a request was echoed and not answered: the ignition is off"
    SPOILT = "responses are damaged, out of step, or of another unit"
    IDENTIFIED = (
        "a unit answered and gave its version; and its passport, if another was read before"
    )
    ACCEPTED = "the unit gives requested parameters"
    REFUSED = "the unit refuses every requested parameter, or every method"
    ENDED = "sampling was stopped, or an error ended it"


class ImpossibleTransition(RuntimeError):
    """A bug: `event` cannot occur in `state`."""

    def __init__(self, state: LineState | None, event: LineTrigger) -> None:
        super().__init__(f"{event.name} cannot occur in state {state.name if state else 'None'}")
        self.state = state
        self.event = event


TRANSITIONS: Final[Mapping[LineState | None, Mapping[LineTrigger, LineState | None]]] = {
    None: {  # not running
        LineTrigger.PORT_MISSING: LineState.NO_PORT,
        LineTrigger.PORT_LOST: LineState.NO_PORT,
        LineTrigger.ECHO_MISSING: LineState.NO_ECHO,
        LineTrigger.SILENT: LineState.ECHO_ONLY,
        LineTrigger.SPOILT: LineState.ECHO_ONLY,
        LineTrigger.IDENTIFIED: LineState.ECU_ALIVE,
        LineTrigger.ENDED: None,
    },
    LineState.NO_PORT: {
        LineTrigger.PORT_MISSING: LineState.NO_PORT,
        LineTrigger.PORT_LOST: LineState.NO_PORT,  # the port opened, and failed at its first use
        LineTrigger.ECHO_MISSING: LineState.NO_ECHO,
        LineTrigger.SILENT: LineState.ECHO_ONLY,
        LineTrigger.SPOILT: LineState.ECHO_ONLY,
        LineTrigger.IDENTIFIED: LineState.ECU_ALIVE,
        LineTrigger.ENDED: None,
    },
    LineState.NO_ECHO: {
        LineTrigger.PORT_LOST: LineState.NO_PORT,
        LineTrigger.ECHO_MISSING: LineState.NO_ECHO,
        LineTrigger.SILENT: LineState.ECHO_ONLY,
        LineTrigger.SPOILT: LineState.ECHO_ONLY,
        LineTrigger.IDENTIFIED: LineState.ECU_ALIVE,
        LineTrigger.ENDED: None,
    },
    LineState.ECHO_ONLY: {
        LineTrigger.PORT_LOST: LineState.NO_PORT,
        LineTrigger.ECHO_MISSING: LineState.NO_ECHO,
        LineTrigger.SILENT: LineState.ECHO_ONLY,
        LineTrigger.SPOILT: LineState.ECHO_ONLY,
        LineTrigger.IDENTIFIED: LineState.ECU_ALIVE,
        LineTrigger.ENDED: None,
    },
    LineState.ECU_ALIVE: {
        LineTrigger.PORT_LOST: LineState.NO_PORT,
        LineTrigger.ECHO_MISSING: LineState.NO_ECHO,
        LineTrigger.SILENT: LineState.ECHO_ONLY,
        LineTrigger.SPOILT: LineState.ECHO_ONLY,
        LineTrigger.IDENTIFIED: LineState.ECU_ALIVE,  # another unit
        LineTrigger.ACCEPTED: LineState.SAMPLING,
        LineTrigger.REFUSED: LineState.ECU_ALIVE,
        LineTrigger.ENDED: None,
    },
    LineState.SAMPLING: {
        LineTrigger.PORT_LOST: LineState.NO_PORT,
        LineTrigger.ECHO_MISSING: LineState.NO_ECHO,
        LineTrigger.SILENT: LineState.ECHO_ONLY,
        LineTrigger.SPOILT: LineState.ECHO_ONLY,
        LineTrigger.ACCEPTED: LineState.SAMPLING,  # another plan
        LineTrigger.REFUSED: LineState.ECU_ALIVE,
        LineTrigger.ENDED: None,
    },
}

FAILURES: Final[tuple[tuple[type[MikasError], LineTrigger], ...]] = (
    (EchoOnly, LineTrigger.SILENT),
    (NoConnection, LineTrigger.ECHO_MISSING),
    (LineError, LineTrigger.SPOILT),
)
"""The event of a failed request, by the first class that matches; a lost port is not here."""


def trigger_of(error: NoConnection | LineError) -> LineTrigger:
    """Return the event of a request that failed with `error`."""
    return next(event for kind, event in FAILURES if isinstance(error, kind))


class LineStateMachine:
    """Follows `TRANSITIONS`; `state` is None while not running."""

    def __init__(self) -> None:
        self.state: LineState | None = None

    def process(self, event: LineTrigger) -> LineState | None:
        """Enter the state that follows `event`, and return it. Raises `ImpossibleTransition`."""
        row = TRANSITIONS[self.state]
        if event not in row:
            raise ImpossibleTransition(self.state, event)
        self.state = row[event]
        return self.state
