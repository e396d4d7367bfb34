"""What other installed distributions bring: entry points of the groups `mikas.links` and so on.

Nothing is imported before it is used, and a fault of one entry does not concern the others.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import TYPE_CHECKING

from mikas.errors import UsageError
from mikas.i18n import Text

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint


def entries_of(group: str) -> dict[str, list[EntryPoint]]:
    """Return the entries by name in lower case; two of one name are of different distributions."""
    from importlib.metadata import entry_points  # slow to import: some 20 ms

    found: dict[str, list[EntryPoint]] = {}
    try:
        entries = list(entry_points(group=group))
    except Exception:  # one distribution's metadata are damaged, whatever it has to do with mikas
        entries = _readable(group)
    for entry in entries:
        found.setdefault(entry.name.lower(), []).append(entry)
    return found


def _readable(group: str) -> list[EntryPoint]:
    """Return the entries of the distributions whose metadata can be read, of each name the first.

    That is how `entry_points` chooses.
    """
    from importlib.metadata import distributions

    found: dict[str, list[EntryPoint]] = {}
    for distribution in distributions():
        with suppress(Exception):
            name = distribution.name.lower().replace("-", "_")
            if name not in found:
                found[name] = [each for each in distribution.entry_points if each.group == group]
    return [each for entries in found.values() for each in entries]


def loaded(name: str, entries: Sequence[EntryPoint]) -> object:
    """Return the object of the entry `name`. Raises `UsageError` for several, or if it fails."""
    if len(entries) > 1:
        names = distributions_of(entries)
        raise UsageError(
            problem=Text(
                f"more than one distribution brings {name}: {names}",
                f"{name}: есть сразу в нескольких пакетах: {names}",
            ),
            advice=Text("Uninstall all but one of them.", "Удалите все, кроме одного."),
        )
    try:
        found: object = entries[0].load()
    except (Exception, SystemExit) as error:  # another distribution's code may raise anything
        raise unfit(name, entries, _cannot_be_loaded(error)) from error
    return found


def is_of_mikas(entries: Sequence[EntryPoint]) -> bool:
    """Whether mikas itself brings the entries."""
    return all(entry.value.startswith("mikas.") for entry in entries)


def unfit(name: str, entries: Sequence[EntryPoint], why: Text) -> UsageError:
    """Return the error for an entry that can't be used, with the distribution that brings it."""
    names = distributions_of(entries)
    return UsageError(
        problem=Text(
            f"{name}: of the distribution {names} {why.en}", f"{name}: из пакета {names} {why.ru}"
        ),
        advice=Text(
            "Update, repair or uninstall that distribution.",
            "Обновите, исправьте или удалите этот пакет.",
        ),
    )


def distributions_of(entries: Sequence[EntryPoint]) -> str:
    """Return the names and versions of the distributions that bring the entries."""
    found = [entry.dist for entry in entries if entry.dist]
    return ", ".join(sorted(f"{dist.name} {dist.version}" for dist in found))


def _cannot_be_loaded(error: BaseException) -> Text:
    why = f"{type(error).__name__}: {error}"
    return Text(f"can't be loaded ({why})", f"не загружается ({why})")
