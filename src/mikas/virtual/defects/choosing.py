"""Cars by name, for `sim:?car=…`: sound, with named defects, or blind.

    healthy                 a sound car, worn as its seed says
    leak:8,coolant_sensor   defects by key; without an amount a noticeable one
    blind:4711              its number decides on its defects, for training; `answer` names them

The blind car of a number is the same in every version only until the table of defects changes.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from random import Random
from typing import Any, Final

from mikas.catalog.loading.fields import schema_of
from mikas.errors import UsageError, usage_error
from mikas.i18n import Text
from mikas.options import nearest
from mikas.virtual.defects.car import WornCar, wear_of
from mikas.virtual.defects.table import DEFECTS, DefectSide, shown
from mikas.virtual.scenarios.scenario import Condition, Start

HEALTHY: Final = "healthy"
BLIND: Final = "blind"
KEYS: Final = tuple(key for key, defect in DEFECTS.items() if defect.sides)
"""The keys of the defects that can be chosen."""

_SOUND_ONES: Final = 1 / 9  # of the blind cars
_LIMITS: Final[Mapping[str, Any]] = {**schema_of(Condition), **schema_of(Start)}
_NUMBER: Final = re.compile(r"[+-]?[0-9]{1,6}([.][0-9]{1,6})?")
_COUNT: Final = re.compile("[0-9]{1,9}")


@dataclass(frozen=True, slots=True)
class ChosenDefect:
    """A defect with its amount."""

    side: DefectSide
    amount: float

    @property
    def key(self) -> str:
        """The key in `DEFECTS`."""
        return self.side.key

    @property
    def text(self) -> Text:
        """Both in words, as `Air leak past the air meter: 8 kg/h`."""
        amount = shown(DEFECTS[self.key], self.side, self.amount)
        return Text(f"{self.side.text.en}: {amount.en}", f"{self.side.text.ru}: {amount.ru}")


def car_of(text: str, seed: int = 0) -> WornCar:
    """Return the car that `text` names; `seed`: of the wear, for all but a blind one.

    Raises `UsageError`.
    """
    defects = {each.key: each.side.value(each.amount) for each in answer(text)}
    words = _words(text)
    return WornCar(defects, wear_of(seed if not _is_blind(words[0]) else words[0]))


def answer(text: str) -> Sequence[ChosenDefect]:
    """Return the defects of the car that `text` names; none: it is sound. Raises `UsageError`."""
    words = _words(text)
    alone = [word for word in words if word == HEALTHY or _is_blind(word)]
    if alone and len(words) > 1:
        raise usage_error(
            f"{alone[0]} stands alone; other defects can't be added to it",
            f"{alone[0]} указывают отдельно; другие неисправности к нему не добавить",
        )
    if alone:
        return () if alone[0] == HEALTHY else _blind(alone[0])
    chosen = [_named(word) for word in words]
    for number, each in enumerate(chosen):
        if any(each.key == other.key for other in chosen[:number]):
            raise usage_error(f"{each.key} is named twice", f"«{each.key}» указано дважды")
    return chosen


def _words(text: str) -> list[str]:
    """Return the words of the list, `blind` with its number as plain as can be."""
    words = re.findall(r"[^,+\s]+", text)
    if not words:
        raise _unknown("")
    return [f"{BLIND}:{_number_of(it)}" if _is_blind(it) else it for it in words]


def _is_blind(word: str) -> bool:
    return word.partition(":")[0] == BLIND


def _number_of(word: str) -> int:
    number = word.partition(":")[2]
    if _COUNT.fullmatch(number):
        return int(number)
    raise usage_error(
        f"a blind car has a number, as {BLIND}:4711; the same number is the same car",
        f"у машины-загадки есть номер, например {BLIND}:4711; тот же номер — та же машина",
    )


def _blind(word: str) -> Sequence[ChosenDefect]:
    chance = Random(f"what is wrong with {word}")
    if chance.random() < _SOUND_ONES:
        return ()
    side = chance.choice(DEFECTS[chance.choice(KEYS)].sides)
    start, end = (side.at(0.7), side.noticeable) if chance.random() < 0.4 else (
        side.noticeable, side.most
    )  # fmt: skip
    return (ChosenDefect(side, float(f"{chance.uniform(start, end):.3g}")),)


def _named(word: str) -> ChosenDefect:
    key, colon, amount = word.partition(":")
    if key not in KEYS:
        raise _unknown(key)
    defect = DEFECTS[key]
    if not colon:
        return ChosenDefect(defect.sides[0], defect.sides[0].noticeable)
    if _NUMBER.fullmatch(amount):
        value = float(amount)
        side = defect.side_of(value)
        if side is not None and _fits(side, value):
            return ChosenDefect(side, value)
    ranges = [_range(side) for side in defect.sides]
    raise usage_error(
        f"“{word}”: the amount of {key} is a number {' or '.join(it.en for it in ranges)}",
        f"«{word}»: величина «{key}» — число {' или '.join(it.ru for it in ranges)}",
    )


def _fits(side: DefectSide, amount: float) -> bool:
    """Whether the model takes the amount."""
    if side.interval is not None:
        return True  # `side_of` has checked it
    try:
        _LIMITS[side.key](Decimal(str(amount)))
    except UsageError:
        return False
    return True


def _range(side: DefectSide) -> Text:
    defect = DEFECTS[side.key]
    unit = defect.unit if not defect.percent else Text("as a share", "в долях")
    ends = f"{side.least:g} … {side.most:g}"
    return Text(f"{ends} {unit.en}", f"{ends} {unit.ru}")


def _unknown(key: str) -> UsageError:
    known = ", ".join((HEALTHY, BLIND, *KEYS))
    close = nearest(key, (HEALTHY, BLIND, *KEYS)) if key else ()
    en, ru = (f"there is no defect “{key}”", f"неисправности «{key}» нет") if key else (
        "car= is empty", "car= пусто"
    )  # fmt: skip
    if close:
        return usage_error(
            f"{en}. Did you mean {close[0]}? Cars: {known}",
            f"{ru}. Может быть, {close[0]}? Есть: {known}",
        )
    return usage_error(f"{en}; cars: {known}", f"{ru}; есть: {known}")
