"""`mikas faults` and `mikas faults erase`."""

from __future__ import annotations

from collections.abc import Sequence

from mikas.catalog import Fault
from mikas.cli.click_extensions import YES, argument, command
from mikas.cli.context import CommandContext
from mikas.cli.language import localized, tr
from mikas.cli.options.parameter_types import OneOf
from mikas.cli.render.values import CONFIDENCE


@command(
    en="Shows the stored faults with their text, its confidence, and what to check. "
    "`faults erase` erases them and reads the memory again.",
    ru="Показывает ошибки в памяти блока: описание, его достоверность, что проверить. "
    "`faults erase` сбрасывает ошибки и перечитывает память.",
    examples=("mikas faults", "mikas faults erase", "mikas faults erase --yes --json"),
)
@argument("action", "[erase]", type=OneOf(["erase"]), required=False)
@YES
def faults(context: CommandContext, action: str | None, *, yes: bool) -> None:
    if action == "erase":
        _erase(context, yes=yes)
        return
    with context.ecu() as ecu:
        stored = ecu.faults()
    if context.output.json:
        context.output.data({"count": len(stored), "faults": [fault.as_json() for fault in stored]})
    else:
        _show(context, stored)


def _erase(context: CommandContext, *, yes: bool) -> None:
    with context.ecu(context.confirm(yes=yes, meaning=_numbers)) as ecu:
        if not context.output.json:
            _show(context, ecu.faults())
        erased = ecu.erase_faults()
    if context.output.json:
        context.output.data(
            {"before": [f.code for f in erased.before], "after": [f.code for f in erased.after]}
        )
        return
    if erased.after:
        context.say(
            "These faults came back at once: their cause remains:",
            "Эти ошибки сразу появились снова: причина не устранена:",
        )
        _show(context, erased.after)
    else:
        context.output.line(
            tr("Erased; no faults are stored.", "Ошибки сброшены; в памяти их нет.")
        )


def _numbers(codes: str) -> str:
    """Return the faults' numbers, as everywhere, of their codes in hex."""
    return ", ".join(map(str, bytes.fromhex(codes)))


def _show(context: CommandContext, stored: Sequence[Fault]) -> None:
    if not stored:
        context.output.line(tr("No faults are stored.", "Ошибок нет."))
        return
    unknown = tr("unknown fault number", "неизвестный номер ошибки")
    words = {sure: localized(text) for sure, text in CONFIDENCE.items()}
    context.output.listing(
        stored,
        {
            tr("code", "код"): lambda fault: str(fault.code),
            tr("fault", "ошибка"): lambda fault: localized(fault.text) or unknown,
            tr("confidence", "достоверность"): lambda fault: words[fault.confidence],
            tr("check first", "что проверить"): lambda fault: localized(fault.check),
            tr("parameters", "параметры"): lambda fault: " ".join(fault.parameters),
        },
        right="0",
    )
