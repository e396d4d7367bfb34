"""`Recording.plot`: its arguments, and the panes that they choose."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Final

from mikas.errors import MissingExtra, usage_error
from mikas.i18n import Text
from mikas.recording.notebook.panes import by_unit, coloured, first_panes
from mikas.recording.notebook.picture import Moment, picture_of
from mikas.recording.table.channels import Channel, named

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from mikas.recording.notebook.drawing import Plot
    from mikas.recording.recording import Recording

_FEWEST: Final = 10  # points of a line


def drawn(
    recording: Recording,
    panes: Sequence[str | Sequence[str]],
    *,
    start: Moment | None,
    end: Moment | None,
    group_by_unit: bool,
    stacked: bool,
    reference: bool,
    points: int,
    figsize: tuple[float, float] | None,
    ax: Axes | None,
) -> Plot:
    """Draw the recording: see `Recording.plot`."""
    try:
        import_module("matplotlib")
    except ImportError as error:
        raise MissingExtra(feature=Text("A plot", "График"), extra="plot") from error
    from mikas.recording.notebook.drawing import draw

    if points < _FEWEST:
        raise usage_error(f"points is at least {_FEWEST}", f"points не может быть меньше {_FEWEST}")
    chosen = chosen_panes(recording, panes, group_by_unit=group_by_unit)
    if ax is not None:
        chosen = [[channel for pane in chosen for channel in pane]]
    picture = picture_of(
        recording,
        coloured(chosen),
        start=start,
        end=end,
        stacked=stacked,
        reference=reference,
        points=points,
    )
    return draw(picture, figsize, ax)


def chosen_panes(
    recording: Recording, panes: Sequence[str | Sequence[str]], *, group_by_unit: bool
) -> list[list[Channel]]:
    """Return the panes that a person names; the chart's own if there are none."""
    known = {channel.name: channel for channel in recording.channels}
    recorded = [it for it in recording.channels if it.name not in recording.absent]
    lists = [[each] if isinstance(each, str) else list(each) for each in panes]
    names = [[named(recording.catalog, name) for name in names] for names in lists]
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
