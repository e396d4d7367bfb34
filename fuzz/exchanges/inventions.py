"""Whether each value shown of a case is right: the unit gave it, to that request (D13)."""

from __future__ import annotations

from typing import Final

from fuzz.exchanges.cases import Case
from fuzz.exchanges.readers import Answer, Disagreement, Expected
from fuzz.exchanges.sessions import CATALOG, Truth
from mikas import commands as c
from mikas.recording.exchanges.fitting import Fitting
from mikas.recording.exchanges.layouts import READ_LIST, STREAMS
from mikas.recording.exchanges.matching import AVAILABILITY
from mikas.recording.inspect import Describer

_READ: Final = b"\x61"


def check(case: Case, found: Expected) -> None:
    """Raise `Disagreement` for a value that is not true. The rows are those of every table."""
    for answer in found.answers:
        _check_answer(answer, case.truths.get(answer.place, Truth()))
    rows = {place: _rows_of(truth) for place, truth in case.truths.items()}
    for place, row in found.rows:
        if not _is_part(row, rows.get(place, [])):
            raise Disagreement("invented row", f"{row} at {place}")


def _check_answer(it: Answer, truth: Truth) -> None:
    if it.request is None or not _FITTING.fits(it.request, it.body, None):
        return
    if it.request == AVAILABILITY or not _is_known(it.request):
        return  # another version than before is shown, for two alike confirm it
    if it.request[:1] not in _DATA:
        if (it.request, it.body) not in truth.other:
            raise Disagreement("invented response", f"{it}")
        return
    if it.codes is None and it.request == READ_LIST:
        return  # its names are not known
    codes = it.codes if it.request == READ_LIST else it.request[1:]
    assert codes is not None
    if None in map(CATALOG.size_of, codes) or not _FITTING.fits(_READ + codes, it.body, None):
        return
    if (it.request, codes, it.body) not in truth.data:
        raise Disagreement("invented data", f"{it}")
    meant = Describer(CATALOG)(_READ + codes, it.body)
    if it.meaning and meant and it.meaning != meant.en:
        raise Disagreement("invented meaning", f"{it}, not {meant.en}")


def _is_known(request: bytes) -> bool:
    """Return whether a value can come of a response to this request."""
    try:
        c.parse(request, CATALOG.size_of)
    except c.MalformedRequest:
        return request == READ_LIST
    return True


def _rows_of(truth: Truth) -> list[dict[str, float]]:
    rows = []
    for _, codes, body in truth.data:
        row: dict[str, float] = {}
        start = 0
        for code in codes:
            size = CATALOG.size_of(code) or 0
            raw, start = body[start : start + size], start + size
            if len(raw) == size:
                row |= {p.name: float(p.decode(raw, "corrected")) for p in CATALOG.by_code(code)}
        rows.append(row)
    return rows


def _is_part(row: tuple[tuple[str, float], ...], rows: list[dict[str, float]]) -> bool:
    return not row or any(all(it.get(name) == value for name, value in row) for it in rows)


_FITTING: Final = Fitting(CATALOG.size_of)
_DATA: Final = frozenset([_READ, READ_LIST, *(bytes([code]) for code in STREAMS)])
