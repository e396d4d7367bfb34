"""`mikas log`: the wire to a file, with what is read told as `watch` tells it."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from mikas.cli.arguments import File
from mikas.cli.commands.watch import samples, sampling_options, show
from mikas.cli.grammar import command, option
from mikas.cli.run import Run
from mikas.cli.words import decimal, say
from mikas.client import Ecu, Sample
from mikas.errors import UsageError
from mikas.language import Text
from mikas.recording.notes import write_session_header


@command(
    "log",
    Text(
        "Records everything on the wire to FILE (.pcapng) while reading each NAME until Ctrl-C. "
        "The file is whole at any moment, even if the computer goes off.",
        "Записывает всё, что есть на линии, в FILE (.pcapng), читая параметры NAME до Ctrl-C. "
        "Файл цел в любой момент, даже если компьютер выключится.",
    ),
    examples=("mikas log -o drive.pcapng", "mikas log -o idle.pcapng FREQ JAIR INJ --duration 60"),
)
@option(
    "-o",
    "--out",
    required=True,
    type=File(),
    metavar="FILE",
    text=Text("where to record; needed", "куда записывать; обязательно"),
)
@sampling_options
def log(
    run: Run,
    names: tuple[str, ...],
    out: Path,
    method: str,
    rate: float | None,
    count: int | None,
    duration: float | None,
) -> None:
    if run.capture is not None:
        raise UsageError(
            problem=Text(
                "log records already, to the file after -o; leave --capture out",
                "Команда log и так записывает, в файл после -o; уберите --capture",
            )
        )
    run.capture, run.records = out, True
    with run.ecu() as ecu:
        _write_head(run, ecu)
        taken = _counted(run, ecu, out, samples(ecu, names, method, rate, count, duration))
        if run.output.json:
            show(run, ecu, taken, names)
        else:
            for _ in taken:
                pass


def _write_head(run: Run, ecu: Ecu) -> None:
    """Whose recording it is and what it is to be read with, before the first sample."""
    assert run.recorder is not None  # `records` asked for it
    write_session_header(
        run.recorder,
        ecu.tester.link.now(),
        version_code=ecu.version_code,
        passports=ecu.passport().pieces,
        catalog_version=ecu.catalog.version,
        adapter=ecu.tester.link.description,
        baud=ecu.tester.link.baud,
        echo=ecu.tester.echoes,
        reading=run.reading,
    )


def _counted(run: Run, ecu: Ecu, out: Path, taken: Iterator[Sample]) -> Iterator[Sample]:
    """Passes the samples on and tells the rate, errors and file size: as they come, and at the
    end.
    """
    count = gaps = 0
    began = last = told = ecu.tester.link.now()
    try:
        for sample in taken:
            count += not sample.gap
            gaps += sample.gap
            last = ecu.tester.link.now()
            if last - told >= 1 and sys.stderr.isatty():
                told = last
                sys.stderr.write("\r\x1b[K" + _told(ecu, out, count, gaps, last - began))
                sys.stderr.flush()
            yield sample
            failure = getattr(ecu.tester.link, "failure", None)
            if failure is not None:
                raise failure
    finally:
        if sys.stderr.isatty():
            sys.stderr.write("\r\x1b[K")
        run.output.note(_told(ecu, out, count, gaps, last - began))


def _told(ecu: Ecu, out: Path, count: int, gaps: int, seconds: float) -> str:
    rate = f"{count / seconds if seconds > 0 else 0.0:.1f}"
    size = 0.0
    with suppress(OSError):
        size = out.stat().st_size / 1024
    failed = ecu.tester.statistics.failed
    return say(
        f"{out}: {count} samples, {rate} a second, {gaps} gaps, {failed} line errors, "
        f"{size:.0f} KiB, {seconds:.0f} s",
        f"{out}: отсчётов {count}, {decimal(rate)} в секунду, пропусков {gaps}, ошибок линии "
        f"{failed}, "
        f"{size:.0f} КиБ, {seconds:.0f} с",
    )
