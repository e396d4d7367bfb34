"""The ECU refused, or a change was not approved (D10, §3)."""

from __future__ import annotations

from mikas.errors.base import MikasError
from mikas.i18n import Text


class EcuRefused(MikasError):
    """The ECU refused the request, or does not know it."""


class WriteRefused(EcuRefused):
    """The ECU answered 01 to a write (§3)."""

    what = Text("The ECU refused the write", "Блок отверг запись")
    advice = Text(
        "This unit does not allow this cell or parameter to be written; nothing was changed.",
        "Этот блок не разрешает запись этой ячейки или параметра; ничего не изменено.",
    )


class NotSupported(EcuRefused):
    """Unknown command or parameter: silence, or 01 where that can't be data (D10)."""

    what = Text("This ECU does not know {command}", "Этот блок не знает {command}")
    advice = Text(
        "Not every unit has every command.",
        "Не каждый блок знает все команды.",
    )


class ReadBackDiffers(EcuRefused):
    """The write was accepted, but another value was read back."""

    what = Text(
        "{name}: {wanted} was written, {got} was read back",
        "{name}: записано {wanted}, прочитано {got}",
    )
    advice = Text(
        "The cell may be read-only, or the unit's program changes it; read it again before you "
        "rely on it.",
        "Возможно, ячейка доступна только для чтения или её меняет программа блока; прочтите её "
        "ещё раз.",
    )


class NotConfirmed(MikasError):
    """A change that was not approved; nothing was sent."""

    what = Text(
        "Not confirmed, nothing was changed: {change}",
        "Не подтверждено, ничего не изменено: {change}",
    )
    advice = Text("{how}", "{how}")
