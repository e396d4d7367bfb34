"""What an answer of a survey says of the protocol's clauses and commands (§3, D1–D17).

A rule gets the value of an answer that the unit has given.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, Final, NamedTuple

from mikas.amendments.amendment import CatalogChange
from mikas.catalog import Catalog
from mikas.catalog.evidence import Agreement
from mikas.commands.unit import PASSPORT_LENGTH
from mikas.i18n import Text

AGREES, DIFFERS, SHOWS = Agreement.AGREES, Agreement.DIFFERS, Agreement.SHOWS
_FIRST_BYTE: Final = 0.5  # s to a response, and between two bytes of one: the limits of D14
_NEXT_BYTE: Final = 0.2
_A_TURN: Final = (0.4, 0.6)  # responses of a stream by strokes: one in two turns (D15)
_ANSWERED: Final = Text("the unit has answered it", "блок на неё ответил")
_LACKS: Final = Text("the unit has not answered it", "блок на неё не ответил")
_FAULTS: Final = Text("the response is a list as §3 has it", "ответ — список, как в §3")
_NO_TEXT: Final = Text(
    "faults without a text here: {codes}", "ошибки, о которых здесь нет текста: {codes}"
)
_LENGTH: Final = Text("the response has {count} bytes", "в ответе байтов: {count}")


class Judgement(NamedTuple):
    """What a value says of these names. `text` empty: the answer's own words."""

    of: tuple[str, ...]
    agreement: Agreement
    text: Text | None = None
    changes: tuple[CatalogChange, ...] = ()


Judge = Callable[[Any, Catalog], Iterable[Judgement]]


def _shows(*of: str) -> Judge:
    return lambda *_: [Judgement(of, SHOWS)]


def agrees(*of: str) -> Judge:
    """Return the rule that any value is as the clause has it."""
    return lambda *_: [Judgement(of, AGREES)]


def _if(fits: Callable[[Any], bool], *of: str) -> Judge:
    """Return the rule that `fits` says whether the value is as the clause has it."""
    return lambda value, _: [Judgement(of, AGREES if fits(value) else DIFFERS)]


def _within(limit: float, of_value: Callable[[Any], float]) -> Judge:
    """Return the rule of a time that D14 leaves open, but gives a limit for."""
    return lambda value, _: [Judgement(("D14",), SHOWS if of_value(value) <= limit else DIFFERS)]


def _longest(value: Mapping[str, float]) -> float:
    return value["median"] + value["spread"]


def _version(value: str, catalog: Catalog) -> Iterator[Judgement]:
    known = catalog.model(int(value, 16)).known
    yield Judgement(("01",), AGREES if known else SHOWS)


def _unknown(value: str, _: Catalog) -> Iterator[Judgement]:
    yield Judgement(("D10",), SHOWS if value in ("silent", "01") else DIFFERS)


def _commands(value: Mapping[str, list[str]], _: Catalog) -> Iterator[Judgement]:
    yield from _each(value["supported"], AGREES, _ANSWERED)
    yield from _each(value["missing"], DIFFERS, _LACKS)


def _each(codes: Iterable[str], agreement: Agreement, text: Text) -> Iterator[Judgement]:
    """Yield one judgement for all of `codes`; none without any."""
    if of := tuple(codes):
        yield Judgement(of, agreement, text)


def _blocks(value: Mapping[str, int], _: Catalog) -> Iterator[Judgement]:
    yield Judgement(tuple(value), SHOWS)


def _strokes(value: Mapping[str, float | None], _: Catalog) -> Iterator[Judgement]:
    rates = [rate for rate in value.values() if rate is not None]
    low, high = _A_TURN
    yield Judgement(("D15",), AGREES if all(low <= it <= high for it in rates) else DIFFERS)


def _passports(value: Mapping[str, int | None], _: Catalog) -> Iterator[Judgement]:
    for count in sorted({each for each in value.values() if each is not None}):
        of = (code for code, each in value.items() if each == count)
        agreement = AGREES if count == PASSPORT_LENGTH else DIFFERS
        yield from _each(of, agreement, _LENGTH.filled(count=count))


def _faults(value: list[int], catalog: Catalog) -> Iterator[Judgement]:
    yield Judgement(("02",), AGREES, _FAULTS)
    if unknown := [str(code) for code in value if not catalog.fault(code).known]:
        yield Judgement(("02",), SHOWS, _NO_TEXT.filled(codes=", ".join(unknown)))


JUDGES: Final[Mapping[str, Judge]] = {
    "version": _version,
    "echo": agrees("D1"),
    "turn_round": _within(_FIRST_BYTE, _longest),
    "turn_round_running": _within(_FIRST_BYTE, _longest),
    "inter_byte": _within(_NEXT_BYTE, float),
    "least_pause": _shows("D14"),
    "unknown": _unknown,
    "commands": _commands,
    "counted_blocks": _if(lambda is_counted: not is_counted, "D7"),
    "max_block": _blocks,
    "max_list_61": _shows("D11"),
    "max_list_64": _shows("D11"),
    "max_list_71": _shows("D11"),
    "long_list": _shows("D11"),
    "list_bytes": _shows("D11"),
    "bad_write": _if(lambda value: value == "01", "D17"),
    "checksum_accepted": _if(lambda value: value in ("both", "stuffed"), "D3"),
    "checksum_sent": _shows("D3"),
    "stream_end": _shows("D12"),
    "stream_gap": _shows("D16"),
    "stream_load": _shows("D16"),
    "strokes": _strokes,
    "count": _shows("60"),
    "passports": _passports,
    "faults": _faults,
}
"""The rule of each question of a survey about clauses and commands."""
