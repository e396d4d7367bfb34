"""Merged entries into derived channels, with the checks that concern several of them at once."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from graphlib import CycleError

from mikas.catalog.confidence import Confidence
from mikas.catalog.derived import Derived, in_order
from mikas.catalog.formulas.syntax import FormulaError, parse
from mikas.catalog.loading.build import does_not_exist, source_of
from mikas.catalog.loading.entries import Entries, Entry
from mikas.catalog.loading.limits import alarm_limits
from mikas.i18n import Text


def derived(entries: Entries, unit_texts: Mapping[str, Text]) -> dict[str, Derived]:
    """The derived channels by name, in the order of the files' tables."""
    _check_names(entries)
    known = (*entries["parameter"], *entries["derived"])
    built = {
        name: _derived(name, entry, unit_texts, known) for name, entry in entries["derived"].items()
    }
    _check_cycles(entries["derived"], built)
    return built


def _derived(
    name: str, entry: Entry, unit_texts: Mapping[str, Text], known: Iterable[str]
) -> Derived:
    entry.require("formula")
    values, constants = entry.values, entry.values.get("constants", {})
    try:
        inputs = parse(values["formula"], constants).inputs
    except FormulaError as error:
        raise entry.wrong(("formula",), error.problem) from None
    for each in inputs:
        if each not in known:
            raise entry.wrong(("formula",), does_not_exist(each, (*known, *constants)))
    unit = values.get("unit", "")
    return Derived(
        name=name,
        text=entry.text("text"),
        formula=values["formula"],
        inputs=inputs,
        constants=tuple(constants.items()),
        accumulates=values.get("accumulates", False),
        unit=unit,
        unit_text=unit_texts.get(unit, Text(unit, unit)),
        decimals=values.get("decimals", 2),
        alarm_limits=alarm_limits(entry, is_flag=False),
        source=source_of(entry),
        confidence=values.get("confidence", Confidence.UNCONFIRMED),
    )


def _check_names(entries: Entries) -> None:
    """Parameters and derived channels share their names. The later file is to blame."""
    for name, entry in entries["derived"].items():
        if (parameter := entries["parameter"].get(name)) is None:
            continue
        if parameter.first[0].order > entry.first[0].order:
            raise parameter.wrong_name(
                Text("is the name of a derived channel", "имя занято производным каналом")
            )
        raise entry.wrong_name(Text("is the name of a parameter", "имя занято параметром"))


def _check_cycles(entries: Mapping[str, Entry], built: Mapping[str, Derived]) -> None:
    """No channel may need itself. The formula that was written last is to blame."""
    try:
        in_order(built, built)
    except CycleError as error:
        circle = error.args[1]
        to_blame = max(
            (entries[name] for name in circle), key=lambda each: each.order(("formula",))
        )
        shown = " → ".join(reversed(circle))
        raise to_blame.wrong(
            ("formula",), Text(f"goes in a circle: {shown}", f"замкнут в круг: {shown}")
        ) from None
