"""Merged entries into the catalog's values, with the checks that concern several keys at once."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from graphlib import CycleError
from pathlib import PurePath
from typing import Any, TypeVar

from mikas.catalog import model
from mikas.catalog.conversion import NO_TEXT, Conversion
from mikas.catalog.formula_syntax import parse
from mikas.catalog.instrument_channels import InstrumentChannel
from mikas.catalog.limits import LIMITS, AlarmLimits, Confidence, Level
from mikas.catalog.loading.conflicts import check_names, check_sizes
from mikas.catalog.loading.entries import Entries, Entry
from mikas.catalog.loading.fields import constant, made, read_value
from mikas.catalog.loading.source import KeyPath
from mikas.catalog.lookup import Catalog
from mikas.catalog.synonyms import Named, named, synonyms_of
from mikas.errors import UsageError
from mikas.i18n import Text
from mikas.options import nearest

T = TypeVar(
    "T",
    model.Derived,
    model.Erratum,
    model.Fault,
    model.Model,
    model.Parameter,
    InstrumentChannel,
)

_OF_NUMBERS = (*LIMITS, "hysteresis")
_OF_FLAGS = ("when_true",)
_ORIGIN = ("source", "confidence")
_LONGEST_CIRCLE = 8  # names shown

NOT_FOR_FLAGS = Text("makes no sense for a flag", "для признака не имеет смысла")
ONLY_FOR_FLAGS = Text("makes sense for a flag only", "имеет смысл только для признака")


def catalog_of(entries: Entries, version: str) -> Catalog:
    """Build the catalog of merged entries, in the order of the files' tables."""
    units = {name: entry.text("text") for name, entry in entries["unit"].items()}
    parameters = tuple(
        _parameter(name, entry, units, entries) for name, entry in entries["parameter"].items()
    )
    check_sizes(entries["parameter"])
    check_names(entries)
    known = {**entries["parameter"], **entries["derived"]}
    beside = entries["instrument"]
    names = synonyms_of(Named(each.name, each.text, each.short) for each in parameters)

    def channel_of(word: str) -> str:  # as `Catalog.input_of`
        return word if word in beside else named(word, known, names)

    derived = {
        name: _derived(name, entry, units, {**known, **beside}, channel_of)
        for name, entry in entries["derived"].items()
    }
    _check_cycles(entries["derived"], derived)
    return Catalog(
        parameters=parameters,
        derived=derived,
        instruments={
            name: instrument_channel(name, entry, units)
            for name, entry in entries["instrument"].items()
        },
        faults={
            code: _fault(code, entry, entries["parameter"])
            for code, entry in entries["fault"].items()
        },
        models={
            code: _built(model.Model, entry, code=code, text=entry.text("text"))
            for code, entry in entries["model"].items()
        },
        errata={name: _erratum(name, entry) for name, entry in entries["erratum"].items()},
        units=units,
        version=version,
    )


def alarm_limits(entry: Entry, *, is_flag: bool) -> AlarmLimits | None:
    """Build the table `limits`; None if no limit is left in it."""
    table = entry.values.get("limits", {})
    unfit, problem = (_OF_NUMBERS, NOT_FOR_FLAGS) if is_flag else (_OF_FLAGS, ONLY_FOR_FLAGS)
    _refuse(entry, (("limits", key) for key in unfit), problem)
    values = {key: value for key, value in table.items() if key not in (*unfit, *_ORIGIN)}
    values |= _origin(entry, "limits", (*LIMITS, *_OF_FLAGS))
    try:
        limits = AlarmLimits(**values)
    except UsageError as error:
        last = max((("limits", key) for key in reversed(_OF_NUMBERS)), key=entry.order)
        problem = Text(f"can't be: {error.reason.en}", f"не годится: {error.reason.ru}")
        raise entry.wrong(last, problem) from None
    return limits if limits.for_number or limits.for_flag else None


def optional(entry: Entry, *path: str) -> Text:
    """Return the text at `path` in both languages; empty if missing."""
    return entry.text(*path) if path in entry.places else NO_TEXT


def _short(entry: Entry) -> Text:
    """Return the short text; the whole one if that is missing, or older than `text`."""
    is_current = entry.order(("short",)) >= entry.order(("text",))
    return entry.text("short" if is_current else "text")


def lamp(entry: Entry, *, is_flag: bool) -> model.Lamp | None:
    """Build the texts of a flag's lamp; None if it has none."""
    if not _fits(entry, "lamp", ONLY_FOR_FLAGS, fits=is_flag):
        return None
    trouble = Level(entry.values["lamp"].get("trouble", Level.NONE))
    return model.Lamp(on=entry.text("lamp", "on"), off=entry.text("lamp", "off"), trouble=trouble)


def meaning(entry: Entry, *, is_flag: bool) -> model.Meaning | None:
    """Build the table `meaning`; None if it is missing."""
    if not _fits(entry, "meaning", NOT_FOR_FLAGS, fits=not is_flag):
        return None
    sides = {side: optional(entry, "meaning", side) for side in ("low", "high")}
    return model.Meaning(**{**sides, **_origin(entry, "meaning", sides)})


def _origin(entry: Entry, table: str, statements: Iterable[str]) -> dict[str, Any]:
    """Return `source` and `confidence` of a table, without those older than a statement in it.

    Else a limit of a person's own would have the source of the shipped one that it overrides.
    """
    values: Mapping[str, Any] = entry.values.get(table, {})
    stated = [(table, key) for key in statements if values.get(key) not in (None, Level.NONE)]
    newest = max(stated, key=entry.order, default=())
    file = entry.places[newest][0] if newest else entry.source
    kept = {
        key: values[key]
        for key in _ORIGIN
        if key in values and entry.order((table, key)) >= entry.order(newest)
    }
    return {"source": PurePath(file.name).name, **kept}


def _fits(entry: Entry, key: str, problem: Text, *, fits: bool) -> bool:
    """Whether the key exists and fits the kind; one of an earlier file need not fit any more."""
    if not fits:
        _refuse(entry, [(key,)], problem)
    return fits and key in entry.values


def _refuse(
    entry: Entry, keys: Iterable[KeyPath], problem: Text, mask: KeyPath = ("mask",)
) -> None:
    """Refuse keys of the other kind in the mask's file or a later one; earlier ones are dropped."""
    for key in keys:
        if key in entry.places and entry.order(key) >= entry.order(mask):
            raise entry.wrong(key, problem)


def _derived(
    name: str,
    entry: Entry,
    unit_texts: Mapping[str, Text],
    known: Mapping[str, Entry],
    channel_of: Callable[[str], str],
) -> model.Derived:
    entry.require("formula")
    values, constants = entry.values, entry.values.get("constants", {})
    for each in constants:
        read_value(*entry.places["constants", each], constant, each)
    try:
        formula = parse(values["formula"], constants, channel_of)
    except UsageError as error:
        raise entry.wrong(("formula",), error.reason) from None
    for each in formula.inputs:
        if each not in known:
            raise entry.wrong(("formula",), does_not_exist(each, (*known, *constants)))
    unit = values.get("unit", "")
    return _built(
        model.Derived,
        entry,
        name=name,
        text=entry.text("text"),
        short=_short(entry),
        formula=formula.text,
        inputs=formula.inputs,
        constants=tuple(constants.items()),
        unit_text=unit_texts.get(unit, Text(unit, unit)),
        alarm_limits=alarm_limits(entry, is_flag=False),
    )


def instrument_channel(
    name: str, entry: Entry, unit_texts: Mapping[str, Text]
) -> InstrumentChannel:
    """Build the channel of an instrument."""
    unit = entry.values.get("unit", "")
    return _built(
        InstrumentChannel,
        entry,
        name=name,
        text=entry.text("text"),
        short=_short(entry),
        unit_text=unit_texts.get(unit, Text(unit, unit)),
        alarm_limits=alarm_limits(entry, is_flag=False),
    )


def _check_cycles(entries: Mapping[str, Entry], built: Mapping[str, model.Derived]) -> None:
    """Refuse a channel that needs itself, at the formula that was written last."""
    try:
        model.in_order(built, built)
    except CycleError as error:
        circle = error.args[1]
        latest = max((entries[name] for name in circle), key=lambda each: each.order(("formula",)))
        names = circle[::-1]
        if len(names) > _LONGEST_CIRCLE:
            names = [*names[: _LONGEST_CIRCLE - 1], "…", names[-1]]
        shown = " → ".join(names)
        problem = Text(f"goes in a circle: {shown}", f"замкнут в круг: {shown}")
        raise latest.wrong(("formula",), problem) from None


_FOR_DISPLAY = ("range", "reference", "gauge", "span_least")
_NUMERIC = ("signed", "scale", "bias", "offset", "unit")


def _fault(code: int, entry: Entry, known: Mapping[str, Entry]) -> model.Fault:
    text, check = entry.text("text"), optional(entry, "check")
    related, sensor = (_names(entry, key, known) for key in ("parameters", "sensor"))
    return _built(
        model.Fault,
        entry,
        code=code,
        text=text,
        check=check,
        check_confidence=_confidence_of(entry.values, "check"),
        parameters=tuple(dict.fromkeys((*related, *sensor))),  # to look at with the fault
        sensor=sensor,
    )


def _erratum(name: str, entry: Entry) -> model.Erratum:
    texts = {key: entry.text(key) for key in ("title", "reason", "default", "alternative")}
    if "family" in entry.values:
        texts["family"] = entry.text("family")
    return _built(model.Erratum, entry, name=name, **texts)


def _parameter(
    name: str, entry: Entry, unit_texts: Mapping[str, Text], entries: Entries
) -> model.Parameter:
    entry.require("code")
    entry.require("size")
    values, size = entry.values, entry.values["size"]
    conversion = _conversion(entry, size, unit_texts, ())
    literal, alternative, family = (
        _conversion(entry, size, unit_texts, (interpretation,))
        if interpretation in values
        else None
        for interpretation in model.INTERPRETATIONS[1:]
    )
    if conversion.is_flag:
        _refuse(entry, ((key,) for key in (*_FOR_DISPLAY, "decimals")), NOT_FOR_FLAGS)
        values = {key: value for key, value in values.items() if key not in _FOR_DISPLAY}
    return _built(
        model.Parameter,
        entry,
        name=name,
        text=entry.text("text"),
        short=_short(entry),
        conversion=conversion,
        literal=literal,
        alternative=alternative,
        family=family,
        decimals=values.get("decimals", _decimals(conversion)),
        plausible=values.get("range"),
        reference=values.get("reference"),
        reference_confidence=_confidence_of(values, "reference"),
        gauge=values.get("gauge"),
        span_least=values.get("span_least"),
        errata=_names(entry, "errata", entries["erratum"]),
        alarm_limits=alarm_limits(entry, is_flag=conversion.is_flag),
        lamp=lamp(entry, is_flag=conversion.is_flag),
        meaning=meaning(entry, is_flag=conversion.is_flag),
    )


def _conversion(
    entry: Entry, size: int, unit_texts: Mapping[str, Text], inside: KeyPath
) -> Conversion:
    """Build the corrected interpretation, or that of the table `inside`, which overrides it."""
    values = dict(entry.values)
    for interpretation in inside:
        values |= entry.values[interpretation]
    if mask := values.get("mask", 0):
        where = _where(entry, inside, "mask")
        _refuse(entry, ((*inside, key) for key in _NUMERIC), NOT_FOR_FLAGS, where)
        if mask >> (8 * size):
            problem = Text(
                f"has bits that do not fit its size ({size})", f"не помещается в байтах: {size}"
            )
            raise entry.wrong(where, problem)
        return Conversion(size, mask=mask)
    unit = values.get("unit", "")
    try:
        return Conversion(
            size=size,
            unit_text=unit_texts.get(unit, Text(unit, unit)),
            **{key: values[key] for key in _NUMERIC if key in values},
        )
    except ValueError:
        problem = Text(
            "is too fine, or too large, to stay exact in 64-bit floats",
            "слишком мелкая или слишком большая величина для точного счёта",
        )
        raise entry.wrong(_where(entry, inside, "scale", "offset"), problem) from None


def _where(entry: Entry, inside: KeyPath, *keys: str) -> KeyPath:
    """Return the first existing of these keys, in `inside` before the entry itself."""
    places = [(*path, key) for path in (inside, ()) for key in keys]
    return next((place for place in places if place in entry.places), ())


def _decimals(conversion: Conversion) -> int:
    if conversion.is_whole:
        return 0
    return next((places for places in (1, 2) if abs(conversion.scale) * 10**places >= 1), 3)


def _confidence_of(values: Mapping[str, Any], key: str) -> Confidence:
    """Return the confidence of `key`; UNKNOWN if the key is missing."""
    default = Confidence.UNCONFIRMED if key in values else Confidence.UNKNOWN
    return Confidence(values.get(f"{key}_confidence", default))


def _built(kind: type[T], entry: Entry, **given: object) -> T:
    """Create the value of an entry: from `given`, and for other fields from the keys of the name.

    By default its source is the name of its last file, and it is unconfirmed.
    """
    keys = {"source": _file(entry), "confidence": Confidence.UNCONFIRMED, **entry.values}
    return made(kind, keys, **given)


def _file(entry: Entry) -> str:
    return PurePath(entry.source.name).name


def _names(entry: Entry, key: str, known: Mapping[str, Entry]) -> tuple[str, ...]:
    """Return a list of names of other, existing entries."""
    names = tuple(name.upper() for name in entry.values.get(key, ()))
    for name in names:
        if name not in known:
            raise entry.wrong((key,), does_not_exist(name, known))
    return names


def does_not_exist(name: str, known: Iterable[str]) -> Text:
    """Return the problem of a reference to a missing entry."""
    close = nearest(name, known)
    return Text(
        f"names {name}, which does not exist" + (f"; the nearest is {close[0]}" if close else ""),
        f"имени {name} нет" + (f"; ближайшее — {close[0]}" if close else ""),
    )
