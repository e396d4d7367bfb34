"""A measurement now, for commands that evaluate a recording: `report`, `causes`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from mikas.cli.context import CommandContext
from mikas.cli.language import decimal, tr
from mikas.cli.options.sampling import SamplingOptions
from mikas.cli.render.notices import Notices
from mikas.cli.render.output import StatusLine
from mikas.cli.sampling_run import SamplingRun, sampling_session
from mikas.i18n import Text
from mikas.sampling.events import UnitFound

if TYPE_CHECKING:
    from mikas.recording.capture.notes import Note
    from mikas.recording.recording import Recording


@contextmanager
def measured_now(
    context: CommandContext,
    options: SamplingOptions,
    stopped: Text | None = None,
    *,
    car: Callable[[UnitFound], Note | None] | None = None,
) -> Iterator[tuple[Recording, SamplingRun]]:
    """Record the first car, and give the recording: a temporary file, unless `--capture` names one.

    `stopped`: the note after Ctrl-C; None: that is the usual end.
    """
    from mikas.recording.recording import Recording

    with TemporaryDirectory(prefix="mikas-") as folder, context.open_ahead() as ahead:
        path = context.capture or Path(folder) / "measured.pcapng"
        with sampling_session(context, options, ahead, path, car=car) as run:
            try:
                _sample(context, run)
            except KeyboardInterrupt:
                if not run.samples:
                    raise
                if stopped is not None:
                    context.say(*stopped)
            status = run.end_recording()
        if status is not None and status.failure is not None:
            raise status.failure
        yield Recording(path, context.options.catalog), run


def _sample(context: CommandContext, run: SamplingRun) -> None:
    progress = StatusLine(context.output, lambda: _progress(run))
    notices = Notices(run, progress.print_notice, verbose=context.output.verbose)
    try:
        with closing(notices.watch()) as events:
            for event in events:
                if isinstance(event, UnitFound):
                    if event.another:
                        return  # the file is of the first car
                    run.acquisition.call(lambda ecu: ecu.faults())
                progress.draw(event.time)
    finally:
        progress.clear()


def _progress(run: SamplingRun) -> str:
    done, seconds = int(run.seconds), run.options.duration
    rate = decimal(f"{run.rate:.1f}")
    if seconds is None:
        return tr(
            f"measuring: {done} s, {rate} samples/s; Ctrl-C ends it",
            f"измерение: {done} с, {rate} опр/с; закончить — Ctrl-C",
        )
    return tr(
        f"measuring: {done} of {seconds:g} s, {rate} samples/s",
        f"измерение: {done} из {seconds:g} с, {rate} опр/с",
    )
