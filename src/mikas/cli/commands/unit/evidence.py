"""`mikas evidence`: what the protocol's clauses and the catalog's entries rest on (no port)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

from mikas.cli.click_extensions import argument, command
from mikas.cli.completion.values import evidence_names
from mikas.cli.context import CommandContext
from mikas.cli.language import localized, tr
from mikas.cli.render.values import CONFIDENCE
from mikas.i18n import Text
from mikas.json_values import json_of

if TYPE_CHECKING:
    from mikas.catalog.grounds import Grounds, Part

_PARTS: Final = {
    "reference": Text("warm idle", "норма на ХХ"),
    "limits": Text("limits that alarm", "пределы тревоги"),
    "meaning": Text("causes of an odd value", "причины отклонения"),
    "check": Text("what to check", "что проверить"),
}


@command(
    en="Shows what each NAME rests on; with no name, everything: what the protocol's source says, "
    "sibling units, and what units that were met have shown. A NAME is a clause (§2.1), a decision "
    "(D3), an erratum (E3), a command (61), a channel (TWAT) or a fault (“fault 13”). Needs no "
    "port.",
    ru="Показывает, на чём держится каждое NAME, без имён — всё: что говорит источник протокола, "
    "что у родственных блоков, что показали встреченные блоки. NAME — пункт (§2.1), решение (D3), "
    "сомнительное место (E3), команда (61), канал (TWAT) или ошибка («fault 13»). Порт не нужен.",
    examples=("mikas evidence", "mikas evidence D11 RCOK", "mikas evidence --json"),
)
@argument("names", "[NAME]...", nargs=-1, shell_complete=evidence_names)
def evidence(context: CommandContext, names: tuple[str, ...]) -> None:
    from mikas.catalog import evidence as known
    from mikas.catalog.grounds import grounds_of, named

    everything = grounds_of(context.options.catalog)
    shown = tuple(named(everything, names)) if names else everything
    sources = known.evidence().sources
    if context.output.json:
        context.output.data(
            {
                "catalog": context.options.catalog.version,
                "evidence": [each.as_json() for each in shown],
                "sources": json_of(sources),
            }
        )
        return
    headers = [
        tr("name", "имя"), tr("meaning", "о чём"), tr("the source", "источник"),
        tr("siblings, other texts", "родственные, другие тексты"),
        tr("seen on a unit", "видели на блоке"), tr("confidence", "достоверность"),
    ]  # fmt: skip
    context.output.table(headers, [row for each in shown for row in _rows(each, parts=bool(names))])
    for key in sorted({key for each in shown for key in each.sources}):
        context.output.print_note(f"{key}: {localized(sources[key])}")


def _rows(grounds: Grounds, *, parts: bool) -> Iterator[list[str]]:
    """Yield the row of a thing, and where it was asked for, rows of its `parts`."""
    sure = grounds.confidence
    yield [
        grounds.name,
        localized(grounds.text),
        localized(grounds.source) or " ".join(grounds.sources),
        localized(grounds.siblings),
        _seen(grounds),
        localized(CONFIDENCE[sure]) if sure else "",
    ]
    for part in grounds.parts if parts else ():
        yield _part(part)


def _part(part: Part) -> list[str]:
    name, sure = localized(_PARTS[part.name]), localized(CONFIDENCE[part.confidence])
    return ["", name, part.source, "", "", sure]


def _seen(grounds: Grounds) -> str:
    if not grounds.sightings:
        return tr("no", "нет")
    return "; ".join(f"{each.unit}: {localized(each.text)}" for each in grounds.sightings)
