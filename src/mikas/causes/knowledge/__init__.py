"""The knowledge of each cause, one TOML file each: texts, complaints, faults, what to check.

How strongly a cause shows is in the tables of `weights`, for the shipped ones. A user's own file
in the folder `causes` beside the config file says it itself, under `[effects]`: by feature, in
spreads of sound cars, at an amount that is noticed (docs/reference/causes.md). `[apart.OTHER]` has
what separates a cause from another by hand, where the unit's values don't.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cache
from pathlib import Path
from typing import Final

from mikas.catalog.loading.fields import (
    ANY,
    TEXT,
    Reader,
    Schema,
    between,
    choice,
    integer,
    read_table,
    string,
)
from mikas.catalog.loading.source import CatalogFile, own_files, read_source
from mikas.causes.features import BY_NAME as FEATURES
from mikas.errors import CatalogError, usage_error
from mikas.i18n import Text

FOLDER: Final = "causes"
"""The folder of the user's causes, beside the config file."""

SYSTEMS: Final = (
    "start", "charging", "idle", "air", "throttle", "mixture", "spark", "knock", "warmth",
)  # fmt: skip
"""The parts of a car whose features a cause may move."""


class Complaint(StrEnum):
    """What an owner says of the car."""

    IDLES_HIGH = "idles-high"
    HUNTS = "hunts"
    NO_START = "no-start"
    NO_POWER = "no-power"
    KNOCKS = "knocks"
    OVERHEATS = "overheats"
    THIRSTY = "thirsty"
    BATTERY = "battery"


COMPLAINTS: Final[Mapping[Complaint, Text]] = {
    Complaint.IDLES_HIGH: Text("idles high", "высокие обороты ХХ"),
    Complaint.HUNTS: Text("idle hunts, dies", "плавает ХХ, глохнет"),
    Complaint.NO_START: Text("won't start, starts badly", "не заводится, плохо заводится"),
    Complaint.NO_POWER: Text("no power, jerks", "не тянет, дёргается"),
    Complaint.KNOCKS: Text("knocks", "детонирует"),
    Complaint.OVERHEATS: Text("overheats", "греется"),
    Complaint.THIRSTY: Text("thirsty", "большой расход"),
    Complaint.BATTERY: Text("battery, charging", "аккумулятор, зарядка"),
}
"""Each complaint in words."""


@dataclass(frozen=True, slots=True)
class HandTest:
    """A test with a meter or by hand, and its findings with `this` cause and with `other`."""

    do: Text
    this: Text
    other: Text


@dataclass(frozen=True, slots=True)
class KnownCause:
    """One cause, in one direction (`variant`), as its file has it.

    `effects`: of a user's cause, by feature, in spreads at a noticeable amount; the shipped ones
    have theirs in the tables. `apart`: what separates the cause by hand from another, by the id of
    that or, of one direction, its name.
    """

    id: str
    variant: str
    text: Text
    check: Text
    complaints: frozenset[Complaint]
    faults: frozenset[int]
    looks_like: tuple[str, ...]
    systems: frozenset[str]
    confidence: str
    source: str
    effects: Mapping[str, float] = field(default_factory=dict)
    apart: Mapping[str, HandTest] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The name in the tables: the id, and the direction where there are several."""
        return name_of(self.id, self.variant)

    def apart_from(self, other: KnownCause) -> HandTest | None:
        """Return what separates this cause from `other` by hand, as this one's file has it."""
        return self.apart.get(other.name) or self.apart.get(other.id)


def name_of(identity: str, variant: str) -> str:
    """Return the name of a cause in one direction; without one, the id."""
    return f"{identity}-{variant}" if variant else identity


@dataclass(frozen=True, slots=True)
class Knowledge:
    """The causes by name, and the error of each file that is not one."""

    causes: Mapping[str, KnownCause]
    errors: tuple[CatalogError, ...] = ()


_DIRECTIONS: Final = ("low", "high", "open", "short")
_COMPLAINT: Final = choice(Complaint, *Complaint)
_ID: Final = re.compile(r"[a-z][a-z0-9_]{0,39}")
_HAND_TEST: Final[Schema] = {"do": TEXT, "this": TEXT, "other": TEXT}


def _list_of(reader: Reader, most: int) -> Reader:
    def read(value: object) -> tuple[object, ...]:
        if not isinstance(value, list) or len(value) > most:
            raise usage_error(
                f"must be a list of up to {most}", f"нужен список, не больше {most} значений"
            )
        return tuple(reader(item) for item in value)

    return read


def _identity(value: object) -> str:
    if isinstance(value, str) and _ID.fullmatch(value):
        return value
    raise usage_error(
        "must be small Latin letters, digits and _", "нужны строчные латинские буквы, цифры и _"
    )


FORM: Final[Schema] = {
    "id": _identity,
    "complaints": _list_of(_COMPLAINT, len(Complaint)),
    "faults": _list_of(integer(0, 255), 50),
    "looks_like": _list_of(_identity, 20),
    "systems": _list_of(choice(str, *SYSTEMS), len(SYSTEMS)),
    "confidence": choice(str, "confirmed", "reported", "unconfirmed"),
    "source": string,
    "text": TEXT,
    **{f"text_{direction}": TEXT for direction in _DIRECTIONS},
    "check": TEXT,
    "effects": {ANY: between(-100, 100)},
    "apart": {ANY: _HAND_TEST},
}


def load(folder: Path | None = None) -> Knowledge:
    """Return the shipped causes and those in the user's `folder`, a later id over an earlier.

    A wrong file is an error of the result; the others still load.
    """
    causes = {cause.name: cause for cause in _shipped()}
    files, problems = own_files(folder)
    errors = [*problems]
    loaded = []
    for path in files:
        try:
            source = read_source(path)
            loaded.append((source, from_source(source, own=True)))
        except CatalogError as error:
            errors.append(error)
    there = {*causes, *(cause.name for _, own in loaded for cause in own)}
    for source, own in loaded:
        if (wrong := _unknown_other(source, own, there)) is not None:
            errors.append(wrong)
            continue
        causes = {name: each for name, each in causes.items() if each.id != own[0].id}
        causes |= {cause.name: cause for cause in own}
    return Knowledge(causes, tuple(errors))


def _unknown_other(
    source: CatalogFile, own: tuple[KnownCause, ...], there: Collection[str]
) -> CatalogError | None:
    """Return the error for an `[apart.OTHER]` of no cause; None: there is none."""
    ids = {name.partition("-")[0] for name in there}
    for other in own[0].apart:
        if (other not in ids and other not in there) or other.partition("-")[0] == own[0].id:
            return source.wrong(
                ("apart", other),
                Text("is not the id of another cause", "это не id другой причины"),
            )
    return None


@cache
def _shipped() -> tuple[KnownCause, ...]:
    paths = sorted(Path(__file__).parent.glob("*.toml"))
    return tuple(cause for path in paths for cause in from_source(read_source(path)))


def from_source(source: CatalogFile, *, own: bool = False) -> tuple[KnownCause, ...]:
    """Return the cause in each of its directions. `own`: a user's, which needs `effects`.

    Raises `CatalogError`.
    """
    keys = read_table(source, (), source.tables, FORM)
    if "id" not in keys:
        keys["id"] = Path(source.name).stem
    texts = {"": keys["text"]} if "text" in keys else {}
    texts |= {each: keys[f"text_{each}"] for each in _DIRECTIONS if f"text_{each}" in keys}
    if not texts or "check" not in keys:
        raise source.error((), "needs [text] and [check]", "нужны [text] и [check]")
    effects = keys.get("effects", {})
    if own and not effects:
        raise source.error((), "needs [effects]", "нужны [effects]")
    for name in effects:
        if name not in FEATURES:
            raise source.wrong(
                ("effects", name),
                Text("is no feature (docs/reference/causes.md)", "нет такого признака"),
            )
    apart = {other: _hand_test(source, other, its) for other, its in keys.get("apart", {}).items()}
    return tuple(
        KnownCause(
            id=keys["id"],
            variant=variant,
            text=_both(text),
            check=_both(keys["check"]),
            complaints=frozenset(keys.get("complaints", ())),
            faults=frozenset(keys.get("faults", ())),
            looks_like=keys.get("looks_like", ()),
            systems=frozenset(keys.get("systems", ())),
            confidence=keys.get("confidence", "unconfirmed"),
            source=keys.get("source", ""),
            effects={name: float(value) for name, value in effects.items()},
            apart=apart,
        )
        for variant, text in texts.items()
    )


def _hand_test(source: CatalogFile, other: str, keys: Mapping[str, Mapping[str, str]]) -> HandTest:
    """Return the three texts. Raises `CatalogError` where one is missing."""
    for key in _HAND_TEST:
        if not any(keys.get(key, {}).values()):
            raise source.wrong(("apart", other), Text(f"needs `{key}`", f"нужен `{key}`"))
    return HandTest(**{key: _both(keys[key]) for key in _HAND_TEST})


def _both(keys: Mapping[str, str]) -> Text:
    first = next(iter(keys.values()))
    return Text(keys.get("en", first), keys.get("ru", first))
