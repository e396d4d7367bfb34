"""`mikas evidence`: what clauses and the catalog's entries rest on, and what a survey would change.

It needs no port.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Final

from mikas.catalog.evidence import Agreement
from mikas.cli.click_extensions import OVERWRITE, argument, command, option
from mikas.cli.completion.values import evidence_names
from mikas.cli.context import CommandContext
from mikas.cli.language import localized, tr
from mikas.cli.options.parameter_types import any_file, check_writable
from mikas.cli.render.values import CONFIDENCE
from mikas.errors import naming_file, usage_error
from mikas.i18n import Text
from mikas.json_values import json_of, picked
from mikas.saving import save

if TYPE_CHECKING:
    from mikas.amendments import Amendment, Proposal
    from mikas.catalog.grounds import Grounds, GroundsPart

_SURVEY: Final = ".zip"
_AGREEMENTS: Final = {
    Agreement.AGREES: Text("agrees", "согласуется"),
    Agreement.DIFFERS: Text("differs", "расходится"),
    Agreement.SHOWS: Text("settles what is open", "решает открытое"),
}
_PARTS: Final = {
    "reference": Text("warm idle", "норма на ХХ"),
    "limits": Text("limits that alarm", "пределы тревоги"),
    "meaning": Text("causes of an odd value", "причины отклонения"),
    "check": Text("what to check", "что проверить"),
}


@command(
    en="Shows what each NAME rests on; with no name, everything: what the protocol's source says, "
    "sibling units, and what units that were met have shown. A NAME is a clause (§2.1), a decision "
    "(D3), an erratum (E3), a command (61), a channel (TWAT) or a fault (“fault 13”). With a "
    "FILE.zip, which `mikas survey` has made of a unit: what that unit would change, and by "
    "--patch the change as a diff of the catalog's files. Needs no port.",
    ru="Показывает, на чём держится каждое NAME, без имён — всё: что говорит источник протокола, "
    "что у родственных блоков, что показали встреченные блоки. NAME — пункт (§2.1), решение (D3), "
    "сомнительное место (E3), команда (61), канал (TWAT) или ошибка («fault 13»). С файлом "
    "FILE.zip, который сделала `mikas survey`: что изменил бы этот блок, а с --patch — само "
    "изменение файлов каталога. Порт не нужен.",
    examples=(
        "mikas evidence",
        "mikas evidence D11 RCOK",
        "mikas evidence unit.zip --patch unit.diff",
    ),
)
@argument("names", "[NAME|FILE.zip]...", nargs=-1, shell_complete=evidence_names)
@option(
    "--patch",
    type=any_file,
    metavar="OUT.diff",
    en="write the change of the catalog's files, for `git apply` in the repository",
    ru="записать изменение файлов каталога, для `git apply` в репозитории",
)
@OVERWRITE
def evidence(
    context: CommandContext, names: tuple[str, ...], patch: Path | None, *, overwrite: bool
) -> None:
    files = [name for name in names if name.lower().endswith(_SURVEY)]
    if not files and patch is None:
        _show_grounds(context, names)
    elif len(files) != 1 or len(names) != 1:
        raise usage_error(
            "Give one survey's ZIP, and no other name with it",
            "Нужен один ZIP обследования, без других имён",
        )
    else:
        _show_proposal(context, Path(files[0]), patch, overwrite=overwrite)


def _show_grounds(context: CommandContext, names: tuple[str, ...]) -> None:
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


def _show_proposal(
    context: CommandContext, survey: Path, out: Path | None, *, overwrite: bool
) -> None:
    from mikas.amendments import patch, propose
    from mikas.catalog import shipped

    if out is not None:
        check_writable(out, overwrite=overwrite)
    proposal = propose(survey, shipped())
    diff = patch(proposal.amendments, proposal.unit)
    if out is not None and diff:
        with naming_file(out):
            save(out, diff, follow=True)
    if context.output.json:
        context.output.data(
            {
                "unit": proposal.unit,
                "amendments": [each.as_json() for each in proposal.amendments],
                "open": [picked(each, "id", "clauses", "text") for each in proposal.open],
                "patch": str(out) if out is not None and diff else None,
            }
        )
        return
    context.output.listing(
        proposal.amendments,
        {
            tr("name", "имя"): lambda it: " ".join(it.of),
            tr("the unit", "блок"): lambda it: localized(_AGREEMENTS[it.agreement]),
            tr("shown by it", "что он показал"): lambda it: localized(it.text),
            tr("changes", "изменит"): lambda it: " ".join(_changed(it)),
        },
    )
    for question in proposal.open:
        name, text = " ".join(question.clauses), localized(question.text)
        context.say(f"{name}, open: {text}", f"{name}, открыто: {text}")
    _say_what_next(context, proposal, out, changes=bool(diff))


def _changed(amendment: Amendment) -> list[str]:
    return [f"{each.name}: {', '.join(each.keys)};" for each in amendment.changes]


def _say_what_next(
    context: CommandContext, proposal: Proposal, out: Path | None, *, changes: bool
) -> None:
    if proposal.is_virtual:
        context.say(
            "This is the survey of a virtual unit: evidence of nothing. A pty counts as one, too: "
            "if a real unit was behind it (socat), survey it through socket: or rfc2217:.",
            "Это обследование виртуального блока: оно ничего не доказывает. За него принимается и "
            "pty: если за ним (socat) был настоящий блок, обследуйте его через socket: или "
            "rfc2217:.",
        )
    if not changes:
        context.say(
            "The catalog has all of it already: there is nothing to change.",
            "В каталоге всё это уже есть: менять нечего.",
        )
    elif out is None:
        context.say(
            "The same as a change of the catalog's files: --patch OUT.diff",
            "То же как изменение файлов каталога: --patch OUT.diff",
        )
    else:
        context.say(
            f"{out}: in the repository, git apply {out}; then python -m tools.docs.generated and "
            "the tests. One unit proves nothing of the next.",
            f"{out}: в репозитории — git apply {out}, затем python -m tools.docs.generated и "
            "тесты. Один блок ничего не доказывает о другом.",
        )


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


def _part(part: GroundsPart) -> list[str]:
    name, sure = localized(_PARTS[part.name]), localized(CONFIDENCE[part.confidence])
    return ["", name, part.source, "", "", sure]


def _seen(grounds: Grounds) -> str:
    if not grounds.sightings:
        return tr("no", "нет")
    return "; ".join(f"{each.unit}: {localized(each.text)}" for each in grounds.sightings)
