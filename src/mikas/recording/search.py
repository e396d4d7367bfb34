"""Search in a recording: the moments at which a condition holds (`FREQ > 3000 and DET`).

The condition is a formula of the catalog (`catalog/formula_syntax.py`) in the corrected
interpretation. It is computed as a derived channel is: an input that is not in a row holds for a
second, or for a cycle if that is longer, so no condition holds by values from both sides of a gap.

    rows       . T T . F T      T  T         . no value; T it holds; F it does not
    hits         1─1     2      3──3         a pause without rows ends a hit
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from mikas.catalog import Catalog, Derived
from mikas.catalog.conversion import NO_TEXT
from mikas.catalog.formula_syntax import LONGEST, parse, tree_of
from mikas.catalog.model import in_order
from mikas.errors import UsageError, usage_error
from mikas.recording.exchanges.arrays import Floats, Mask
from mikas.recording.recording import Recording
from mikas.recording.table.channels import Rows, joined_rows
from mikas.recording.table.derived import Deriver

PAUSE: Final = 2.0  # s, as of a gap; more where such steps are usual
_ALIKE: Final = 2.5  # times the usual step
_PIECE: Final = 8192  # rows: of a chain of a thousand channels 64 MB
_CONDITION, _PEAK = "?", "?PEAK"  # no channel has such a name
_HIGH, _LOW = (ast.Gt, ast.GtE), (ast.Lt, ast.LtE)


@dataclass(frozen=True, slots=True)
class Hit:
    """The condition holds in `rows` rows in a row: of the times `begin` to `end`, link's clock.

    `peak`: the extreme of what the condition compares first, and its time; None: it has none.
    """

    begin: float
    end: float
    rows: int
    peak: float | None = None
    peak_time: float | None = None


@dataclass(frozen=True, slots=True)
class SearchResult:
    """The hits, and the times of the first and the last row; None: there are no rows.

    `damaged`: the number of places in the file that could not be read.
    """

    hits: list[Hit]
    begin: float | None
    end: float | None
    damaged: int = 0


class SearchCondition:
    """A condition on the channels of `catalog`, also of instruments.

    `inputs`: the channels that it names. `requires`: the parameters that these need; `beside`: the
    instruments' channels. `peak_of`: the formula that its first comparison compares with something,
    of which a hit has the extreme: the lowest value of a `<` (`is_lowest`), else the highest; empty
    without a comparison. `cost`: operations for each row, with those of the derived channels.

    Raises `UsageError` for a formula that is none, `UnknownParameter` with the nearest names.
    """

    def __init__(self, catalog: Catalog, expression: str) -> None:
        self.expression: str = " ".join(expression.split())
        try:
            parsed = parse(self.expression, {}, catalog.input_of)
        except UsageError as error:
            raise usage_error(
                f"The condition {error.reason.en}", f"Условие: {error.reason.ru}"
            ) from error
        self.inputs: tuple[str, ...] = tuple(
            catalog.formula_channel(name).name for name in parsed.inputs
        )
        peak_of, is_lowest = _first_comparison(parsed.text)
        self.peak_of: str = peak_of
        self.is_lowest: bool = is_lowest
        formulas = {_CONDITION: parsed.text}
        if self.peak_of:
            formulas[_PEAK] = self.peak_of
        derived = {name: _channel(name, formula) for name, formula in formulas.items()}
        self.catalog: Catalog = replace(catalog, derived={**catalog.derived, **derived})
        self.names: tuple[str, ...] = tuple(derived)
        self.requires: tuple[str, ...] = self.catalog.required_by(self.names)
        self.beside: tuple[str, ...] = self.catalog.required_beside(self.names)
        steps = in_order(self.catalog.derived, self.names)
        self.cost: int = sum(each.calculation().cost for each in steps)

    def find(self, stretches: Iterable[Rows]) -> SearchResult:
        """Return the hits in rows with the columns `names`, in their order."""
        known = [Rows(np.empty(0), dict.fromkeys(self.names, np.empty(0)))]
        ends: list[float] = []
        for rows in stretches:
            if len(rows.times):
                ends += [float(rows.times.min()), float(rows.times.max())]
            known.append(rows.part(np.isfinite(rows.values[_CONDITION])))
        found = joined_rows(known)  # where it holds or does not
        runs = _runs(found.times, found.values[_CONDITION] != 0)
        hits = [self._hit(found.part(slice(first, last + 1))) for first, last in runs]
        return SearchResult(hits, min(ends, default=None), max(ends, default=None))

    def _hit(self, rows: Rows) -> Hit:
        hit = Hit(float(rows.times[0]), float(rows.times[-1]), len(rows.times))
        peaks = rows.values.get(_PEAK)
        if peaks is None or np.isnan(peaks).all():
            return hit
        at = int((np.nanargmin if self.is_lowest else np.nanargmax)(peaks))
        return replace(hit, peak=float(peaks[at]), peak_time=float(rows.times[at]))


def search(recording: Recording, condition: SearchCondition) -> SearchResult:
    """Return the hits in a recording, in the order of the file.

    Raises `UsageError` if a channel of the condition is not recorded.
    """
    catalog = condition.catalog
    recording = recording.interpreted("corrected", condition.names, catalog=catalog)
    if _CONDITION in recording.absent:
        absent = _absent(recording, condition)
        names = ", ".join(absent)
        is_beside = any(each in condition.beside for each in absent)
        raise usage_error(
            f"{names}: not in this recording, so the condition has no value anywhere"
            + ("; a channel of an instrument needs one beside the unit" if is_beside else ""),
            f"{names}: в этой записи нет, поэтому у условия нигде нет значения"
            + ("; канал прибора есть там, где прибор стоял рядом с блоком" if is_beside else ""),
        )
    found = condition.find(recording.rows())
    return replace(found, damaged=recording.problem_count)


def _absent(recording: Recording, condition: SearchCondition) -> list[str]:
    """Return the channels of the condition that are not recorded."""
    of_unit = [name for name in condition.inputs if name in condition.catalog.channels]
    absent = recording.interpreted("corrected", of_unit).absent if of_unit else ()
    found = {*absent, *condition.beside} - {*recording.instrument_channels}
    return [name for name in dict.fromkeys((*condition.inputs, *condition.beside)) if name in found]


def search_rows(rows: Rows, condition: SearchCondition) -> SearchResult:
    """Return the hits in rows of what the condition `requires`, corrected, and has `beside`."""
    deriver = Deriver(condition.catalog, condition.names)

    def computed() -> Iterator[Rows]:
        for at in range(0, len(rows.times), _PIECE):
            piece = rows.part(slice(at, at + _PIECE))
            beside = {name: it for name, it in piece.values.items() if name in condition.beside}
            own = {name: it for name, it in piece.values.items() if name not in beside}
            columns = deriver.columns(Rows(piece.times, own), beside)
            yield Rows(piece.times, columns)

    return condition.find(computed())


def _runs(times: Floats, holds: Mask) -> Iterator[tuple[int, int]]:
    """Yield the first and the last row of each hit."""
    steps = np.diff(times)
    usual = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    joined = (steps >= 0) & (steps <= max(PAUSE, _ALIKE * usual)) & holds[1:] & holds[:-1]
    begins = holds & ~np.concatenate(([False], joined))[: len(holds)]
    ends = holds & ~np.concatenate((joined, [False]))[: len(holds)]
    return zip(begins.nonzero()[0].tolist(), ends.nonzero()[0].tolist(), strict=True)


def _channel(name: str, formula: str) -> Derived:
    return Derived(name, NO_TEXT, formula, parse(formula, {}).inputs)


def _first_comparison(expression: str) -> tuple[str, bool]:
    """Return what the first comparison compares, and whether its lowest value is the extreme."""
    for node in _in_order(tree_of(expression)):
        if not isinstance(node, ast.Compare):
            continue
        operator, (right,) = node.ops[0], node.comparators
        for side, low in ((node.left, _LOW), (right, _HIGH)):
            if names := _channel_names(side):
                for name in names:
                    name.id = name.id.upper()
                formula = ast.unparse(side)  # with its own spaces: it may have grown too long
                return formula if len(formula) <= LONGEST else "", isinstance(operator, low)
    return "", False


def _in_order(node: ast.AST) -> Iterable[ast.AST]:
    """Yield `node` and all nodes in it, as they are written."""
    yield node
    for child in ast.iter_child_nodes(node):
        yield from _in_order(child)


def _channel_names(side: ast.expr) -> list[ast.Name]:
    """Return the names in a formula that are not those of functions."""
    functions = {id(node.func) for node in ast.walk(side) if isinstance(node, ast.Call)}
    names = (node for node in ast.walk(side) if isinstance(node, ast.Name))
    return [name for name in names if id(name) not in functions]
