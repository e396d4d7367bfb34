"""`mikas faults` and `mikas faults erase`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import click

from mikas.catalog import Confidence, Fault
from mikas.cli.arguments import OneOf
from mikas.cli.grammar import YES, command
from mikas.cli.run import Run
from mikas.cli.words import localized, tr
from mikas.i18n import Text


@command(
    "faults",
    Text(
        "Shows the stored faults with their text, how sure that text is, and what to check. "
        "`faults erase` erases them and reads back.",
        "Показывает запомненные ошибки: что они значат, насколько это достоверно, что проверить. "
        "`faults erase` стирает их и перечитывает.",
    ),
    examples=("mikas faults", "mikas faults erase", "mikas faults erase --yes --json"),
)
@click.argument("action", metavar="[erase]", type=OneOf(["erase"]), required=False)
@YES
def faults(run: Run, action: str | None, *, yes: bool) -> None:
    if action == "erase":
        _erase(run, yes=yes)
        return
    with run.ecu() as ecu:
        stored = ecu.faults()
    if run.output.json:
        run.output.data({"count": len(stored), "faults": [_as_json(fault) for fault in stored]})
    else:
        _show(run, stored)


def _erase(run: Run, *, yes: bool) -> None:
    with run.ecu(run.confirm(yes=yes)) as ecu:
        if not run.output.json:
            _show(run, ecu.faults())
        erased = ecu.erase_faults()
    if run.output.json:
        run.output.data(
            {"before": [f.code for f in erased.before], "after": [f.code for f in erased.after]}
        )
        return
    if erased.after:
        run.output.note(
            tr(
                "These came back at once, so their cause is still there:",
                "Эти появились сразу же снова, значит причина осталась:",
            )
        )
        _show(run, erased.after)
    else:
        run.output.line(tr("Erased; no faults are stored.", "Стёрто; ошибок нет."))


def _show(run: Run, stored: Sequence[Fault]) -> None:
    if not stored:
        run.output.line(tr("No faults are stored.", "Ошибок нет."))
        return
    run.output.table(
        [
            tr("code", "код"),
            tr("fault", "неисправность"),
            tr("how sure", "достоверность"),
            tr("check first", "сначала проверить"),
            tr("look at", "смотреть"),
        ],
        [
            [
                str(fault.code),
                localized(fault.text)
                or tr("what this number means is not known", "что значит этот номер, неизвестно"),
                _sure(fault.confidence),
                localized(fault.check),
                " ".join(fault.parameters),
            ]
            for fault in stored
        ],
        right="0",
    )


def _sure(confidence: Confidence) -> str:
    return {
        Confidence.CONFIRMED: tr("confirmed", "подтверждено"),
        Confidence.REPORTED: tr("one source", "один источник"),
        Confidence.UNCONFIRMED: tr("unconfirmed", "не подтверждено"),
        Confidence.UNKNOWN: tr("unknown", "неизвестно"),
    }[confidence]


def _as_json(fault: Fault) -> dict[str, Any]:
    return {
        "code": fault.code,
        "text": {"en": fault.text.en, "ru": fault.text.ru},  # empty for an unknown one
        "confidence": fault.confidence,
        "check": {"en": fault.check.en, "ru": fault.check.ru},
        "parameters": fault.parameters,
    }
