"""What a test waits for: the conditions of its formula that do not hold, with value and limit.

`A and B` is two conditions. Of `A or B` each part is shown while neither holds; comparisons of
`SECONDS` are left out, since the seconds are shown anyway. A part that compares no single channel
with a number shows the values of its channels.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import isfinite
from typing import Final

from mikas.catalog import Catalog, Derived
from mikas.catalog.formula_syntax import Operation, Parsed, Term
from mikas.catalog.formulas import Calculation
from mikas.guided.definition import SECONDS
from mikas.i18n import Text
from mikas.recording.formatting import quantity


@dataclass(frozen=True, slots=True)
class Unmet:
    """A channel whose value keeps the test waiting. `value` None: there is none just now.

    `sign` and `limit`: the comparison that has to hold; without one a sign is empty.
    """

    name: str
    value: float | None
    sign: str
    limit: float | None
    text: Text


def unmet(
    formula: Parsed | None, values: Mapping[str, float], catalog: Catalog
) -> tuple[Unmet, ...]:
    """Return the conditions of `formula` that do not hold with `values`, each channel once."""
    found: dict[str, Unmet] = {}
    if formula is not None:
        for condition in _parts(formula.plain, is_and=True):
            if not _holds(condition, values):
                for name, sign, limit in _comparisons(condition):
                    if name != SECONDS and name not in found:
                        found[name] = _unmet(name, sign, limit, values, catalog)
    return tuple(found.values())


def _parts(term: Term, *, is_and: bool) -> Iterator[Term]:
    """Yield the parts of `a and b`, or those of `a or b` (the plain forms of formula_syntax)."""
    while isinstance(term, Operation) and term.name == "where":
        condition, then, otherwise = term.operands
        if is_and and otherwise == 0.0 and then != 1.0:
            yield condition
            term = then
        elif not is_and and then == 1.0 and otherwise != 0.0:
            yield condition
            term = otherwise
        else:
            break
    yield term


def _comparisons(term: Term) -> Iterator[tuple[str, str, float | None]]:
    for part in _parts(term, is_and=False):
        nested = list(_parts(part, is_and=True))
        if len(nested) > 1:
            for each in nested:
                yield from _comparisons(each)
        elif isinstance(part, str):
            yield part, "!=", 0.0
        elif isinstance(part, Operation) and part.name in _MIRRORED and len(part.operands) == 2:
            left, right = part.operands
            if isinstance(left, str) and isinstance(right, float):
                yield left, part.name, right
            elif isinstance(left, float) and isinstance(right, str):
                yield right, _MIRRORED[part.name], left
            else:
                yield from ((name, "", None) for name in _names(part))
        else:
            yield from ((name, "", None) for name in _names(part))


def _names(term: Term) -> Iterator[str]:
    if isinstance(term, str):
        yield term
    elif isinstance(term, Operation):
        for each in term.operands:
            yield from _names(each)


def _holds(term: Term, values: Mapping[str, float]) -> bool:
    names = tuple(dict.fromkeys(_names(term)))
    if any(name not in values for name in names):
        return False
    if not names:
        return True
    number = Calculation(Parsed(term, names, ())).number(values)
    return isfinite(number) and number != 0


def _unmet(
    name: str, sign: str, limit: float | None, values: Mapping[str, float], catalog: Catalog
) -> Unmet:
    channel, value = catalog.formula_channel(name), values.get(name)
    shown = _NO_VALUE if value is None else quantity(value, channel)
    if sign == "" or limit is None:
        filled = _PLAIN.filled(name=channel.short, value=shown)
    elif not isinstance(channel, Derived) and channel.is_flag:
        wanted = _ON if (sign == "==") is bool(limit) else _OFF
        filled = _FLAG.filled(name=channel.short, wanted=wanted)
    else:
        wanted = _SIGNS[sign].filled(limit=quantity(limit, channel))
        filled = _WANTED.filled(name=channel.short, value=shown, wanted=wanted)
    return Unmet(name, value, sign, limit, filled)


_MIRRORED: Final = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "==": "==", "!=": "!="}
_SIGNS: Final[Mapping[str, Text]] = {
    "<": Text("less than {limit}", "меньше {limit}"),
    "<=": Text("at most {limit}", "не больше {limit}"),
    ">": Text("more than {limit}", "больше {limit}"),
    ">=": Text("at least {limit}", "не меньше {limit}"),
    "==": Text("exactly {limit}", "ровно {limit}"),
    "!=": Text("not {limit}", "не {limit}"),
}
_WANTED: Final = Text("{name} {value}: {wanted} is needed", "{name} {value}: нужно {wanted}")
_PLAIN: Final = Text("{name} {value} does not fit", "{name} {value}: не подходит")
_FLAG: Final = Text("{name}: has to be {wanted}", "{name}: нужно «{wanted}»")
_ON, _OFF = Text("on", "включено"), Text("off", "выключено")
_NO_VALUE: Final = Text("without a value", "нет данных")
