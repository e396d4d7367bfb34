"""The ECU said no, or nobody said yes (D10, §3)."""

from __future__ import annotations

from mikas.errors.base import MikasError
from mikas.i18n import Text


class EcuRefused(MikasError):
    """The ECU understood, or did not know the request, and said no."""


class WriteRefused(EcuRefused):
    """The ECU answered 01 to a write (§3)."""

    what = Text("The ECU refused the write", "Блок отверг запись")
    advice = Text(
        "This unit does not let this cell or parameter be written; nothing was changed.",
        "Этот блок не даёт записать эту ячейку или параметр; ничего не изменено.",
    )


class NotSupported(EcuRefused):
    """The ECU does not know the command or the parameter: silence, or 01 where it can't be data
    (D10).
    """

    what = Text("This ECU does not know {command}", "Этот блок не знает {command}")
    advice = Text(
        "Not every unit has every command; `mikas info` shows what this one has.",
        "Не каждый блок знает все команды; что знает этот, показывает `mikas info`.",
    )
    advice_on_screen = Text(
        "Not every unit has every command; the Passport screen shows what this one has.",
        "Не каждый блок знает все команды; что знает этот, показывает экран «Паспорт».",
    )


class ReadBackDiffers(EcuRefused):
    """The write was accepted, but the cell then held something else."""

    what = Text(
        "{name} was written with {wanted} but then held {got}",
        "В {name} записано {wanted}, а читается {got}",
    )
    advice = Text(
        "The cell may be read-only or driven by the program; read it again before relying on it.",
        "Ячейка может быть только для чтения или её меняет программа; прочтите её ещё раз.",
    )


class NotConfirmed(MikasError):
    """A change that nobody approved; nothing was sent."""

    what = Text(
        "Not confirmed, nothing was changed: {change}",
        "Не подтверждено, ничего не изменено: {change}",
    )
    advice = Text("{how}", "{how}")
