"""The panes of a chart: which channels are drawn together, and in which colours.

Those of the dashboard's chart (`web/src/screens/chart/time/view.svelte.ts`, `styles/tokens.css`); a
test holds both equal. A person who names none gets these, as far as they are recorded.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import cycle
from typing import TYPE_CHECKING, Final

from mikas.errors import usage_error
from mikas.recording.table.channels import Channel, named

if TYPE_CHECKING:
    from mikas.recording.recording import Recording

FIRST: Final = (("FREQ", "THR"), ("INJ", "JAIR"), ("UOZ",), ("TWAT", "UACC"))
MOST: Final = 5  # panes that the chart makes by itself


@dataclass(frozen=True, slots=True)
class Palette:
    """The colours of a theme."""

    traces: tuple[str, ...]
    text: str
    muted: str
    hatch: str
    warning: str
    danger: str


DAY: Final = Palette(
    ("#0072b2", "#b86e00", "#00805c", "#857a00", "#a8457f", "#c04a00", "#3a55c9", "#20262b"),
    text="#0b0f12",
    muted="#434d55",
    hatch="#6b7680",
    warning="#704300",
    danger="#852800",
)
NIGHT: Final = Palette(
    ("#56b4e9", "#e69f00", "#1fbf8f", "#f0e442", "#d98cb8", "#ff7a3d", "#5b9bf5", "#e8ecef"),
    text="#f1f4f6",
    muted="#a9b4bd",
    hatch="#77838e",
    warning="#f2b134",
    danger="#ff8d62",
)


@dataclass(frozen=True, slots=True)
class Trace:
    """A channel in a pane. `colour`: its place in a palette's traces."""

    channel: Channel
    colour: int


Pane = tuple[Trace, ...]


def axis_key(channel: Channel) -> str:
    """Return what the lines of one axis have in common: their unit.

    A flag has an axis of its own, and so has a channel without a unit.
    """
    return f"own {channel.name}" if channel.is_flag or not channel.unit else channel.unit


def chosen_panes(
    recording: Recording, panes: Sequence[str | Sequence[str]], *, group_by_unit: bool
) -> list[list[Channel]]:
    """Return the panes that a person names; the chart's own if there are none."""
    known = {channel.name: channel for channel in recording.channels}
    recorded = [it for it in recording.channels if it.name not in recording.absent]
    lists = [[each] if isinstance(each, str) else list(each) for each in panes]
    names = [
        [beside if (beside := name.strip().upper()) in known else named(recording.catalog, name)
         for name in names]
        for names in lists
    ]  # fmt: skip
    for name in (name for pane in names for name in pane if name not in known):
        raise usage_error(
            f"{name} is not among this recording's channels: {', '.join(known)}",
            f"{name} нет среди каналов этой записи: {', '.join(known)}",
        )
    chosen = [[known[name] for name in dict.fromkeys(pane)] for pane in names if pane]
    if group_by_unit:
        each = {it.name: it for pane in chosen for it in pane}
        return by_unit(each.values() if each else recorded)
    return chosen or first_panes(recorded)


def first_panes(channels: Sequence[Channel]) -> list[list[Channel]]:
    """Return the chart's own panes of the recorded channels; without any, a pane for each unit."""
    known = {channel.name: channel for channel in channels}
    panes = [[known[name] for name in names if name in known] for names in FIRST]
    return [pane for pane in panes if pane] or by_unit(channels)[:MOST]


def by_unit(channels: Iterable[Channel]) -> list[list[Channel]]:
    """Return a pane for each unit, in the order of the channels, and one with all flags."""
    panes: dict[str, list[Channel]] = {}
    for channel in channels:
        key = "flag" if channel.is_flag else f"unit {axis_key(channel)}"
        panes.setdefault(key, []).append(channel)
    return list(panes.values())


def coloured(panes: Iterable[Sequence[Channel]]) -> list[Pane]:
    """Return the panes with the colours in their order, through all panes."""
    colours = cycle(range(len(DAY.traces)))
    return [tuple(Trace(channel, next(colours)) for channel in pane) for pane in panes]
