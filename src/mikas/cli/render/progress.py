"""A progress bar with the time left, on a terminal only."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol

from mikas.cli.language import tr
from mikas.cli.render.output import stderr_console
from mikas.cli.render.terminal import cell_text


class Advance(Protocol):
    """Advances the bar by `count`; `what` replaces the text before it."""

    def __call__(self, count: int, what: str | None = None, /) -> None: ...


@contextmanager
def progress(what: str, total: int, already: int = 0, *, speed: bool = True) -> Iterator[Advance]:
    """Show a bar for `total` items, bytes if `speed` is to be shown."""
    if not sys.stderr.isatty():
        yield lambda _, __=None: None
        return
    from rich.progress import (
        BarColumn,
        Progress,
        ProgressColumn,
        Task,
        TextColumn,
        TimeRemainingColumn,
    )
    from rich.text import Text as RichText

    class Speed(ProgressColumn):
        """Bytes per second; rich's own column is English only."""

        def render(self, task: Task) -> RichText:
            speed = f"{task.finished_speed or task.speed or 0:.0f}"
            return RichText(tr(f"{speed} bytes/s", f"{speed} байт/с"))

    with Progress(
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TextColumn("{task.completed:.0f}/{task.total:.0f}"),
        *([Speed()] if speed else []),
        TimeRemainingColumn(),
        console=stderr_console(),
    ) as bar:
        task = bar.add_task(cell_text(what), total=total, completed=already)

        def advance(count: int, text: str | None = None, /) -> None:
            bar.update(task, advance=count, description=cell_text(what if text is None else text))

        yield advance
