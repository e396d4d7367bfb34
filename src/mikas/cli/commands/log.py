"""`mikas log`: record the line to a file; values are printed as `watch` prints them."""

from __future__ import annotations

import _thread
import signal
import threading
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Final

from mikas.cli.click_extensions import command, option, output_option
from mikas.cli.context import CommandContext
from mikas.cli.failures import DONE, USAGE
from mikas.cli.language import capital, decimal, localized, tr
from mikas.cli.options.actions import ActionOptions, action_options
from mikas.cli.options.car import CarOptions, car_options
from mikas.cli.options.parameter_types import Portion, portion
from mikas.cli.options.sampling import INSTRUMENTS, SamplingOptions, sampling_options
from mikas.cli.render.output import StatusLine
from mikas.errors import usage_error
from mikas.i18n import plural

_SHOWN = 40  # characters of a name that is being typed

_LONGEST_END: Final = 1.0  # s from Ctrl-C to the end of a recording

if TYPE_CHECKING:
    from collections.abc import Iterator
    from concurrent.futures import Future

    from mikas.cli.sampling_run import SamplingRun
    from mikas.client import Ecu
    from mikas.conditions import LoadedActions
    from mikas.recording.recorder import RecordingStatus
    from mikas.sampling.events import Event


@command(
    en="Records everything on the line to FILE (.pcapng) while reading each NAME until Ctrl-C. "
    "The file is valid at any moment, even if the computer loses power. If the adapter is "
    "unplugged or the ignition switched off, it waits and continues in the same file; another "
    "car gets FILE-2. On a terminal, Enter sets a marker; text typed before it is its name.",
    ru="Записывает весь обмен на линии в FILE (.pcapng), читая параметры NAME до Ctrl-C. Файл "
    "цел в любой момент, даже если компьютер выключится. Если отключён адаптер или выключено "
    "зажигание, ждёт и продолжает в том же файле; для другой машины начинает FILE-2. В "
    "терминале Enter ставит отметку; текст, набранный перед ним, — её имя.",
    examples=(
        "mikas log -o drive.pcapng",
        "mikas log -o idle.pcapng FREQ JAIR INJ TWAT/10 --duration 60",
        "mikas log -o long.pcapng --rotate 1h",
        "mikas log -o drive.pcapng --instrument aem=/dev/ttyUSB1 --instrument nmea=/dev/ttyUSB2",
    ),
)
@output_option(
    "FILE",
    endings=["pcapng"],
    en="file to record to; required",
    ru="файл записи; обязательно",
)
@option(
    "--rotate",
    type=portion,
    metavar="SIZE|TIME",
    en="continue in FILE-2, FILE-3 … after this size or time: 100MB, 30min, 2h",
    ru="продолжать в FILE-2, FILE-3 … после такого объёма или времени: 100MB, 30min, 2h",
)
@INSTRUMENTS
@action_options
@car_options
@sampling_options
def log(
    context: CommandContext,
    options: SamplingOptions,
    car: CarOptions,
    actions: ActionOptions,
    *,
    out: Path,
    rotate: Portion | None,
    instruments: tuple[str, ...],
) -> int:
    if context.capture is not None:
        raise usage_error(
            "log already records to the file after -o; omit --capture",
            "Команда log и так записывает, в файл после -o; уберите --capture",
        )
    loaded = None
    if actions.actions is not None:
        from mikas.cli.acting import load

        loaded, options = load(context, actions.actions, options, instruments)
    with context.open_ahead(instruments) as ahead:  # imports take as long as the handshake listens
        from mikas.cli.sampling_run import sampling_session

        _check_name(out)
        with sampling_session(
            context, options, ahead, out, car=car.note_maker(), instruments=instruments
        ) as current:
            return _record(context, current, rotate, loaded)


def _check_name(out: Path) -> None:
    """Raise for a name that `log` can't record to."""
    if str(out) == "-":
        raise usage_error(
            "A recording needs a file: -o drive.pcapng; to pipe values, use --json",
            "Для записи нужен файл: -o drive.pcapng; чтобы передать значения другой программе, "
            "есть --json",
        )
    from mikas.recording.export import SUFFIXES, TRACKS

    if out.suffix.lower() in (*SUFFIXES, *TRACKS):
        name = out.with_suffix(".pcapng").name
        raise usage_error(
            f"The command log records the line, not {out.suffix}: record with "
            f"-o {name}, then `mikas export {name} -o {out.name}`",
            f"Команда log записывает обмен на линии, а не {out.suffix}: запишите с "
            f"-o {name}, затем `mikas export {name} -o {out.name}`",
        )


def _record(
    context: CommandContext,
    current: SamplingRun,
    rotate: Portion | None,
    actions: LoadedActions | None,
) -> int:
    from mikas.cli.acting import acting
    from mikas.cli.markers import Marking
    from mikas.cli.render.notices import Notices
    from mikas.cli.render.values import json_line

    output = context.output
    progress = StatusLine(output, lambda: _progress(current))
    rotation = _FileRotation(current, rotate)
    current.session.wants_faults = current.is_recording
    try:
        show = partial(_show_typed, progress) if progress.live else None
        notices = Notices(current, progress.print_notice, verbose=output.verbose)
        with (
            Marking(current.recorder, progress.print_notice, show),
            _last_reading(current),
            acting(
                context, current, actions, progress.print_notice, marks=True, stops=True
            ) as follow,
            closing(notices.watch()) as events,
        ):
            for event in events:
                if output.json:
                    json_line(current, output, event)
                follow(event)
                progress.draw(event.time)
                rotation.rotate_after(event)
    finally:
        status = current.end_recording()
        progress.clear()
        if current.answered and status is not None:  # else no ECU ever answered
            output.print_note(f"{_summary(current, status)}{_of_an_export(current)}")
    if status is None or status.failure is None:
        return DONE
    if output.json:
        raise status.failure
    return USAGE  # the notice of the failure stands above


def _show_typed(progress: StatusLine, typed: str) -> None:
    """Show the name of a marker while it is typed."""
    progress.begin_with(f"{tr('Marker', 'Отметка')}: {typed[-_SHOWN:]}▏ " if typed else "")


@contextmanager
def _last_reading(current: SamplingRun) -> Iterator[None]:
    """Let Ctrl-C read the faults before the recording ends, for a second; another one ends at once.

    Where there is nothing to read, the first one does, too.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    timers: list[threading.Timer] = []

    def on_interrupt(*_: object) -> None:
        if not current.end_soon():
            raise KeyboardInterrupt
        timers.append(threading.Timer(_LONGEST_END, _thread.interrupt_main))
        timers[-1].daemon = True
        timers[-1].start()

    before = signal.signal(signal.SIGINT, on_interrupt)
    try:
        yield
    finally:
        for timer in timers:
            timer.cancel()
        signal.signal(signal.SIGINT, before)


class _FileRotation:
    """Start the next file when this one has reached its size or time."""

    def __init__(self, current: SamplingRun, portion: Portion | None) -> None:
        self._current = current
        self._portion = portion or Portion()
        self._job: Future[None] | None = None

    def rotate_after(self, event: Event) -> None:
        status = self._current.recorder.status
        if status is None or status.failure or (self._job and not self._job.done()):
            return
        full = self._portion.bytes is not None and status.bytes >= self._portion.bytes
        if self._portion.seconds is not None and status.since is not None:
            full = full or event.time - status.since >= self._portion.seconds
        if full:
            # Between two cycles, which restarts a stream. While no ECU answers, it fails and is
            # tried again; the file does not grow meanwhile.
            self._job = self._current.acquisition.call(self._next_file)

    def _next_file(self, ecu: Ecu) -> None:
        self._current.session.read_between(ecu, routine=False)
        ecu.forget_list()
        self._current.recorder.next_file()
        self._current.session.read_between(ecu, routine=False)


def _progress(current: SamplingRun) -> str:
    """Return rate, errors and file size, after the state of a broken line; empty without a file."""
    status = current.recorder.status
    if status is None:
        return ""
    if current.waiting is not None and status.failure is None:
        return f"{capital(localized(current.waiting.text))} · {_summary(current, status)}"
    return _summary(current, status)


def _of_an_export(current: SamplingRun) -> str:
    """Explain the rows of an export where the user has set the number of samples."""
    if current.options.count is None and current.options.rate is None:
        return ""
    return tr(
        ". The file has every response on the line, those before the samples too: an export makes "
        "a row of each.",
        ". В файле все ответы на линии, в том числе до замеров: при экспорте каждый станет "
        "строкой.",
    )


def _summary(current: SamplingRun, status: RecordingStatus) -> str:
    rate = f"{current.rate:.1f}"
    size, seconds = status.bytes / 1024, current.seconds
    lost = min(status.lost, current.samples)
    but, ru_but = (
        (f"{lost} of them not recorded, ", f"из них не записано: {lost}, ")
        if status.failure is not None
        else ("", "")
    )
    summary = tr(
        f"{status.path}: {plural(current.samples, 'sample', 'samples')}, {but}{rate} readings/s, "
        f"{plural(status.gaps, 'gap', 'gaps')}, "
        f"{plural(current.errors, 'line error', 'line errors')}, {size:.0f} KiB, {seconds:.0f} s",
        f"{status.path}: замеров: {current.samples}, {ru_but}{decimal(rate)} опр/с, "
        f"пропусков: {status.gaps}, ошибок линии: {current.errors}, {size:.0f} КиБ, "
        f"{seconds:.0f} с",
    )
    if status.failure is not None:
        return f"{tr('NOT RECORDING', 'ЗАПИСЬ ПРЕКРАЩЕНА')} · {summary}"
    return summary
