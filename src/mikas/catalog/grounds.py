"""What each thing that the program knows rests on: clauses, commands, parameters, faults, errata.

    grounds_of(catalog) ──► Grounds("D11", …), Grounds("TWAT", …), Grounds("fault 13", …), …

What the source says, and what units have shown, is in `mikas.catalog.evidence`; sources and
confidence of parameters, channels, faults and models are those of the catalog's entries.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Final, Literal

from mikas.catalog.conversion import NO_TEXT
from mikas.catalog.evidence import Basis, EvidenceTable, Sighting, evidence
from mikas.catalog.instrument_channels import InstrumentChannel
from mikas.catalog.limits import AlarmLimits, Confidence
from mikas.catalog.lookup import Catalog
from mikas.catalog.model import Derived, Fault, Model, Parameter
from mikas.commands import COMMANDS_BY_CODE
from mikas.errors import usage_error
from mikas.i18n import Text
from mikas.json_values import json_of, picked
from mikas.options import nearest

__all__ = ["Grounds", "GroundsPart", "grounds_of", "named", "parameter_grounds"]

Kind = Literal["clause", "decision", "command", "parameter", "erratum", "channel", "fault", "model"]
_COMMAND: Final = re.compile(r"[0-9A-F]{2}")
_LAW: Final = "§4"  # the source of a parameter of the protocol


@dataclass(frozen=True, slots=True)
class GroundsPart:
    """Another statement of an entry, with a source and a confidence of its own."""

    name: Literal["reference", "limits", "meaning", "check"]
    """Which one: warm idle, the limits that alarm, causes of an odd value, what to check."""
    confidence: Confidence
    """How well it is known."""
    source: str = ""
    """Where it is from; empty: not said."""


@dataclass(frozen=True, slots=True)
class Grounds:
    """What one thing rests on."""

    name: str
    """`§2.1`, `D3`, `61`, `TWAT`, `E3`, `FUEL_FLOW`, `fault 13`, `model 0A`."""
    kind: Kind
    """What it is."""
    text: Text = NO_TEXT
    """What it is about."""
    source: Text = NO_TEXT
    """What the protocol's source says; of a user's own entry the file, of a fault nothing."""
    siblings: Text = NO_TEXT
    """What sibling units and other texts say; empty: nothing."""
    sources: tuple[str, ...] = ()
    """The keys of the public pages that a fault's text is from."""
    confidence: Confidence | None = None
    """How well it is known; None: `source` says it in words."""
    parts: tuple[GroundsPart, ...] = ()
    """Its statements with a source of their own."""
    sightings: tuple[Sighting, ...] = ()
    """What units that were met have shown; empty: none was met."""

    def as_json(self) -> dict[str, Any]:
        """Return it as JSON values."""
        names = ("name", "kind", "text", "sources", "confidence", "parts")
        return picked(self, *names) | self.statement_json()

    def statement_json(self) -> dict[str, Any]:
        """Return the statements about it, and what units have shown, as JSON values."""
        seen = [picked(each, "unit", "agreement", "text") for each in self.sightings]
        return picked(self, "source", "siblings") | {"seen": json_of(seen)}


def grounds_of(catalog: Catalog) -> tuple[Grounds, ...]:
    """Return the grounds of everything, in the order of the protocol's page; then the catalog's."""
    known = evidence()
    on_page = (
        _on_the_page(name, basis, catalog, known) for basis in known.bases for name in basis.of
    )
    return (
        *filter(None, on_page),
        *(_parameter(each, known) for each in catalog.parameters),
        *map(_channel, catalog.derived.values()),
        *map(_channel, catalog.instruments.values()),
        *(_fault(each, known) for _, each in sorted(catalog.faults.items())),
        *(_model(each, known) for each in catalog.models.values()),
    )


def parameter_grounds(parameter: Parameter) -> Grounds:
    """Return what a parameter rests on."""
    return _parameter(parameter, evidence())


def named(grounds: Iterable[Grounds], names: Iterable[str]) -> Iterator[Grounds]:
    """Yield the grounds of these names, each once, in their own order.

    A name is in any case; a number means a command and a fault, `§2` also its parts. Raises
    `UsageError` for one that there is not, with the nearest.
    """
    grounds = tuple(grounds)
    known = {each.name.casefold(): each.name for each in grounds}
    words = {name.strip().casefold(): name for name in names}
    for word, name in words.items():
        if not any(_means(word, each) for each in known):
            near = [known[each] for each in nearest(word, known)]
            hint = Text("; the nearest is {0}", "; ближайшее — {0}") if near else NO_TEXT
            hint = Text(*(each.format(*near) for each in hint))
            raise usage_error(
                f"Nothing is named “{name}”{hint.en}. There are clauses (§2.1), decisions (D3), "
                "errata (E3), commands (61), channels (TWAT), faults (“fault 13”)",
                f"Имени «{name}» нет{hint.ru}. Есть пункты (§2.1), решения (D3), сомнительные "
                "места (E3), команды (61), каналы (TWAT), ошибки («fault 13»)",
            )
    return (each for each in grounds if any(_means(w, each.name.casefold()) for w in words))


def _means(word: str, name: str) -> bool:
    return word in {name, name.removeprefix("§"), name.rpartition(" ")[2]} or (
        word.startswith("§") and name.startswith(f"{word}.")
    )


def _on_the_page(name: str, basis: Basis, catalog: Catalog, known: EvidenceTable) -> Grounds | None:
    """Return the grounds of a clause, decision, erratum or command; None: it is a parameter."""
    kind: Kind
    if name in known.titles:
        kind, text = "clause" if name.startswith("§") else "decision", known.titles[name]
    elif name in catalog.errata:
        kind, text = "erratum", catalog.errata[name].title
    elif _COMMAND.fullmatch(name):
        kind, text = "command", COMMANDS_BY_CODE[int(name, 16)].TITLE
    else:
        return None
    seen = known.sightings_of(name)
    return Grounds(name, kind, text, basis.source, basis.siblings, sightings=seen)


def _parameter(parameter: Parameter, known: EvidenceTable) -> Grounds:
    name, source = parameter.name, parameter.source
    basis = known.basis_of(name) if source == _LAW else None
    said = basis or Basis((), Text(source, source))
    return Grounds(
        name,
        "parameter",
        parameter.text,
        said.source,
        said.siblings,
        confidence=parameter.confidence,
        parts=tuple(_parts(parameter)),
        sightings=known.sightings_of(name) if basis else (),
    )


def _parts(parameter: Parameter) -> Iterator[GroundsPart]:
    if parameter.reference:
        yield GroundsPart("reference", parameter.reference_confidence)
    yield from _limits(parameter.alarm_limits)
    if meaning := parameter.meaning:
        yield GroundsPart("meaning", meaning.confidence, meaning.source)


def _limits(limits: AlarmLimits | None) -> Iterator[GroundsPart]:
    if limits:
        yield GroundsPart("limits", limits.confidence, limits.source)


def _channel(channel: Derived | InstrumentChannel) -> Grounds:
    source, parts = Text(channel.source, channel.source), tuple(_limits(channel.alarm_limits))
    sure = channel.confidence
    return Grounds(channel.name, "channel", channel.text, source, confidence=sure, parts=parts)


def _fault(fault: Fault, known: EvidenceTable) -> Grounds:
    name = f"fault {fault.code}"
    return Grounds(
        name,
        "fault",
        fault.text,
        sources=fault.sources,
        confidence=fault.confidence,
        parts=(GroundsPart("check", fault.check_confidence),) if fault.check.en else (),
        sightings=known.sightings_of(name),
    )


def _model(model: Model, known: EvidenceTable) -> Grounds:
    name, source = f"model {model.code:02X}", Text(model.source, model.source)
    sure, seen = model.confidence, known.sightings_of(name)
    return Grounds(name, "model", model.text, source, confidence=sure, sightings=seen)
