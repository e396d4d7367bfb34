"""The defects by key: texts, amounts and the wear of a sound car, from `defects.toml`.

    DEFECTS["leak"].sides[0].at(0.5)           # half the noticeable amount: 3 kg/h
    DEFECTS["throttle_stops"].sides[0].value(3)  # what `Condition` holds: (3.0, 100.0)

A new key of `Condition` needs a table there (a test holds both equal).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Any, Final, TypeAlias

from mikas.catalog.loading.fields import (
    TEXT,
    Schema,
    boolean,
    made,
    number,
    read_table,
    schema_of,
    span,
)
from mikas.catalog.loading.source import CatalogFile, read_source
from mikas.errors import usage_error
from mikas.i18n import Text, unit_after
from mikas.virtual.scenarios.scenario import Condition, Start

Value: TypeAlias = "float | tuple[float, float]"
"""What a field of `Condition` or `Start` holds."""

SOUND: Final[Mapping[str, Any]] = {
    each.name: each.default
    for each in (*fields(Condition), *fields(Start))
    if each.name in Condition.__annotations__ or each.name in ("battery", "discharged")
}
"""The value of each key in a sound car without wear."""


PLAIN: Final = Text("{}", "{}")


def _interval(value: object) -> tuple[float | None, float | None]:
    """Read `[15, "amount"]`: the amount is None."""
    if isinstance(value, list) and len(value) == 2 and value.count("amount") == 1:
        low, high = (None if end == "amount" else float(number(end)) for end in value)
        return low, high
    raise usage_error(
        'must be [number, "amount"] or ["amount", number]',
        'нужно [число, "amount"] или ["amount", число]',
    )


@dataclass(frozen=True, slots=True)
class DefectSide:
    """One direction in which a value leaves its sound range: amounts from `sound` to `most`."""

    key: str
    text: Annotated[Text, TEXT]
    sound: Annotated[float, number]
    least: Annotated[float, number]
    noticeable: Annotated[float, number]
    most: Annotated[float, number]
    interval: Annotated[tuple[float | None, float | None] | None, _interval] = None
    amount: Annotated[Text, TEXT] = PLAIN  # how an amount is said

    def at(self, share: float) -> float:
        """Return the amount at a share of the noticeable one: 0 is sound, 0.5 half of it."""
        return self.sound + share * (self.noticeable - self.sound)

    def value(self, amount: float) -> Value:
        """Return what the field of this key holds for an amount."""
        if self.interval is None:
            return float(amount)
        low, high = (float(amount) if end is None else end for end in self.interval)
        return low, high

    def contains(self, amount: float) -> bool:
        """Whether the amount lies on this side of the sound one; of an interval, up to `most`."""
        if amount == self.sound:
            return False
        if self.interval is None:
            return (amount > self.sound) == (self.most > self.sound)
        return min(self.sound, self.most) <= amount <= max(self.sound, self.most)


@dataclass(frozen=True, slots=True)
class Defect:
    """One key. `wear`: the range of sound cars; `sides`: none for a key that only varies."""

    key: str
    unit: Annotated[Text, TEXT]
    sides: tuple[DefectSide, ...] = ()
    wear: Annotated[tuple[float, float] | None, span] = None
    percent: Annotated[bool, boolean] = False  # a share, shown as %

    @property
    def of_start(self) -> bool:
        """Whether the value is one of the scenario's start, not of its condition."""
        return self.key not in Condition.__annotations__

    def side_of(self, amount: float) -> DefectSide | None:
        """Return the side on which the amount lies; None: on none."""
        return next((side for side in self.sides if side.contains(amount)), None)


_SIDE: Schema = schema_of(DefectSide)
FORM: Schema = {**schema_of(Defect), "low": _SIDE, "high": _SIDE}


def from_source(source: CatalogFile) -> Mapping[str, Defect]:
    """Return the defects by key, in the file's order. Raises `CatalogError`."""
    tables = read_table(source, (), source.tables, dict.fromkeys(SOUND, FORM))
    return {key: _defect(key, keys) for key, keys in tables.items()}


def shown(defect: Defect, side: DefectSide, amount: float) -> Text:
    """Return an amount in words, as `25 % of its cooling is left`."""
    number = f"{amount * (100 if defect.percent else 1):.4g}".replace("-", "\N{MINUS SIGN}")
    unit = unit_after(Text(number, number.replace(".", ",")), defect.unit)
    gap = "" if defect.unit.en == "°" else "\N{NO-BREAK SPACE}"
    return Text(
        side.amount.en.replace("{}", f"{number}{gap}{unit.en}"),
        side.amount.ru.replace("{}", f"{number.replace('.', ',')}{gap}{unit.ru}"),
    )


def _defect(key: str, keys: dict[str, Any]) -> Defect:
    sides = tuple(
        made(
            DefectSide,
            {"sound": SOUND[key]} | keys[name],
            key=key,
            text=Text(**keys[name]["text"]),
            amount=Text(**keys[name]["amount"]) if "amount" in keys[name] else PLAIN,
        )
        for name in keys
        if name in ("low", "high")
    )
    return made(Defect, keys, key=key, unit=Text(**keys["unit"]), sides=sides)


DEFECTS: Final = from_source(read_source(Path(__file__).parent / "defects.toml"))
"""Every key, with those that only wear."""

SIDES: Final = tuple(side for defect in DEFECTS.values() for side in defect.sides)
"""Every defect in each of its directions."""
