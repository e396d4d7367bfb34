"""`mikas report`: a report on the car, from a recording or measured now."""

from __future__ import annotations

from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING

from mikas.cli.click_extensions import OVERWRITE, argument, command, option, output_option
from mikas.cli.completion.values import RECORDING, files
from mikas.cli.context import CommandContext
from mikas.cli.language import current_language, localized
from mikas.cli.options.car import CarOptions, car_options
from mikas.cli.options.common import RELEARN
from mikas.cli.options.parameter_types import existing_file, positive
from mikas.cli.options.sampling import SamplingOptions
from mikas.errors import usage_error
from mikas.i18n import Text
from mikas.json_values import json_of, picked

if TYPE_CHECKING:
    from mikas.recording.recording import Recording
    from mikas.report.findings import ChannelFinding, Findings
    from mikas.report.measurements.alarms import Alarm

_SECONDS = 30.0


@command(
    en="Makes a report on the car (OUT.html) to read, print or send: stored faults in plain "
    "words, values at warm idle with their normal range, charts, and what remains unknown. "
    "Made from the recording FILE or, without it, from the connected car: measured for half a "
    "minute, best with the warm engine idling.",
    ru="Делает отчёт о машине (OUT.html), который можно прочитать, напечатать или переслать: "
    "ошибки понятными словами, значения на прогретом холостом ходу и их нормы, графики и то, "
    "чего узнать не удалось. По записи FILE, а без неё — по подключённой машине: полминуты "
    "измерений, лучше на прогретом холостом ходу.",
    examples=(
        "mikas report drive.pcapng -o drive.html",
        "mikas report -o car.html --duration 60 --lang ru",
    ),
)
@argument("file", "[FILE]", required=False, type=existing_file, shell_complete=files(*RECORDING))
@output_option(endings=["html"])
@option(
    "--duration",
    type=positive,
    metavar="S",
    en=f"measure for so many seconds ({_SECONDS:g}); not with FILE",
    ru=f"измерять столько секунд ({_SECONDS:g}); без FILE",
)
@OVERWRITE
@RELEARN
@car_options
def report(
    context: CommandContext,
    car: CarOptions,
    file: Path | None,
    out: Path,
    *,
    duration: float | None,
    overwrite: bool,
) -> None:
    if file is not None and (duration is not None or context.capture or context.relearn):
        raise usage_error(
            "--duration, --capture and --relearn apply to measuring now; with FILE nothing is "
            "measured",
            "--duration, --capture и --relearn действуют при измерении; с FILE ничего не "
            "измеряется",
        )
    from mikas.causes.knowledge import load
    from mikas.cli.config import own_causes
    from mikas.recording.recording import Recording
    from mikas.report.from_recording import find_in_recording
    from mikas.report.page import check_output, render, write_page

    check_output(out, overwrite=overwrite)

    if file is not None:
        recording = Recording(file, context.options.catalog, last_car=True)
        _name_cars(context, recording)
        found = find_in_recording(recording, car=car.details, knowledge=load(own_causes()))
    else:
        found = _measured_now(context, duration or _SECONDS, car)
    write_page(out, render(found, current_language()), overwrite=overwrite)
    _print_summary(context, out, found)


def _name_cars(context: CommandContext, recording: Recording) -> None:
    """Print that the report is of one of several cars."""
    from mikas.recording.annotations.cars import several

    if len(recording.raw.cars) > 1:
        words = several(recording.raw.cars)
        context.say(
            f"{recording.path}: {words.en}. The report is of the last recording's car.",
            f"{recording.path}: {words.ru}. Отчёт — о машине последней записи.",
        )


def _measured_now(context: CommandContext, seconds: float, car: CarOptions) -> Findings:
    """Record for `seconds` and evaluate that; the file is kept only if `--capture` names it."""
    from mikas.causes.knowledge import load
    from mikas.cli.config import own_causes
    from mikas.cli.measuring import measured_now
    from mikas.report.from_recording import find_in_recording

    options = SamplingOptions(duration=seconds)
    with measured_now(context, options, _STOPPED, car=car.note_maker()) as (recording, run):
        name = recording.path.name if context.capture else ""
        known = load(own_causes())
        return find_in_recording(recording, name=name, errors=run.errors, knowledge=known)


_STOPPED = Text(
    "Stopped early: the report covers the time measured.",
    "Прервано: отчёт составлен по измеренной части.",
)


def _print_summary(context: CommandContext, out: Path, found: Findings) -> None:
    from mikas.report.sections.freeze_frames import latest_frames
    from mikas.report.sections.summary import summary_sentence

    verdict = summary_sentence(found)
    if not context.output.json:
        context.output.print_note(f"{localized(verdict)}\n{out}")
        return
    stored = found.subject.faults
    faults = None if stored is None else [fault.code for fault in stored]
    context.output.data(
        {
            "out": str(out),
            "outcome": found.outcome.value,
            "verdict": verdict._asdict(),
            "causes": None if found.subject.causes is None else found.subject.causes.as_json(),
            "faults": faults,
            "freeze_frames": [
                picked(frame, "code", "without", "seen") | {"values": json_of(frame.then)}
                for frame in latest_frames(found)
            ],
            "alarms": [_alarm_as_json(alarm) for alarm in found.measured.alarms],
            "warm_idle_seconds": round(found.measured.idle.seconds, 3),
            "values": {value.channel.name: _as_json(value) for value in found.rated},
            "trip": _trip_as_json(found),
            "mixture": _mixture_as_json(found),
        }
    )


def _trip_as_json(found: Findings) -> dict[str, object] | None:
    """Return the sums of the session's drives; None without an instrument of speed or place."""
    from mikas.drives import joined_trips

    drive = found.subject.drive
    total = None if drive is None else joined_trips(drive.trips)
    return None if total is None else total.as_json()


def _mixture_as_json(found: Findings) -> dict[str, object] | None:
    mixture = found.subject.mixture
    if mixture is None:
        return None
    names = ("rpm", "load", "count", "aimed", "measured", "difference", "low", "high", "verdict")
    cells = [picked(cell, *names) for cell in mixture.cells]
    return {**picked(mixture, "load", "unsteady", "lean"), "cells": cells}


def _alarm_as_json(alarm: Alarm) -> dict[str, object]:
    return {
        **picked(alarm.limit, "name", "level", "side"),
        "limit": alarm.limit.value,
        "times": alarm.times,
        "seconds": round(alarm.seconds, 3),
        "peak": alarm.peak if isfinite(alarm.peak) else None,
    }


def _as_json(value: ChannelFinding) -> dict[str, object]:
    return {
        **picked(value.stats, "median", "low", "high"),
        "unit": value.channel.unit,
        "reference": value.channel.reference,
        "mark": value.mark.value,
    }
