"""What an answer of a survey says of the parameters and the errata (§4, E1–E4), and the changes.

RCOK and RCOD (E3): at warm idle little is corrected. A byte near 128 is neutral by the readings
`alternative` and `family`, and takes half the fuel away by the letter; a byte near 255 is neutral
by the letter. `alternative` and `family` are the same correction, as a deviation and as a factor,
so no byte decides between them: RCOK is a factor by its name and in sibling units.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Final

from mikas.amendments.amendment import CatalogChange
from mikas.amendments.clauses import AGREES, DIFFERS, SHOWS, Judge, Judgement, agrees
from mikas.catalog import Catalog, Parameter
from mikas.catalog.undecided import READING_NAMES
from mikas.i18n import Text, joined
from mikas.recording.formatting import digits

_PLACES: Final = 3
_LETTER_IS_NEUTRAL: Final = 231  # from here on the letter gives −0.1 … 0
_SIZES: Final = Text("61 gives its code, with the size of §4", "61 даёт его код, размер как в §4")
_OTHER_SIZE: Final = Text("61 gives bytes of it: {size}", "61 даёт байтов: {size}")
_ABSENT: Final = Text("61 does not give its code", "61 его кода не даёт")
_MORE: Final = Text("codes beyond §4, by bytes: {codes}", "коды сверх §4, по числу байтов: {codes}")
_WARM: Final = Text(
    "raw {raw:02X} at warm idle, where little is corrected: {readings}",
    "байт {raw:02X} на прогретом холостом ходу, где поправка мала: {readings}",
)
_CODES: Final = {"RCOK": "42", "RCOD": "41"}
_CHANGED: Final[Mapping[str, Mapping[str, Any]]] = {
    "RCOK": {
        "bias": -128,
        "offset": 0,
        "literal": {"bias": 128, "offset": -0.5},
        "alternative": {"bias": 128},
        "gauge": [0.5, 1.5],
    },
    "RCOD": {"offset": 0, "literal": {"offset": -0.5}, "gauge": [-0.5, 0.5]},
}
_TAKEN: Final = {
    "RCOK": ("(b + 128)/256", "(b − 128)/256 − 0.5"),
    "RCOD": ("(b − 128)/256", "(b − 128)/256 − 0.5"),
}
"""The formula of each once it is changed, and by the letter."""


def _confirmed(*of: str, parameter: str) -> Judgement:
    """Return that a unit and a person's instrument agree with the source: two sources."""
    change = CatalogChange("parameters.toml", "parameter", parameter, {"confidence": "confirmed"})
    return Judgement(of, AGREES, changes=(change,))


def _freq(value: Mapping[str, Any], _: Catalog) -> Iterator[Judgement]:
    """The starter alone shows the unit of time; the factor 40 takes an instrument, or a count."""
    of = ("E1", "FREQ")
    by_dial = value["tachometer"] is not None and value["raw"] is not None
    by_instrument = by_dial or value["by_hand"] is not None
    yield _confirmed(*of, parameter="FREQ") if by_instrument else Judgement(of, AGREES)


def _uacc(value: Mapping[str, Any], _: Catalog) -> Iterator[Judgement]:
    of = ("E2", "UACC")
    if value["formula"] == "b/10":
        yield _confirmed(*of, parameter="UACC")
        return
    letter = {"signed": True, "scale": "1/10", "offset": 0}
    keys = {"scale": "1/20", "offset": 5.2, "literal": letter}
    taken = {
        "en": "b/20 + 5.2, unsigned, as in sibling units: a voltmeter showed it.",
        "ru": "b/20 + 5,2, без знака, как у родственных блоков: показал вольтметр.",
    }
    yield Judgement(
        of,
        DIFFERS,
        changes=(
            CatalogChange("parameters.toml", "parameter", "UACC", keys),
            CatalogChange("errata.toml", "erratum", "E2", {"default": taken}),
        ),
    )


def _factors(value: Mapping[str, Mapping[str, Any]], catalog: Catalog) -> Iterator[Judgement]:
    judged = [
        found
        for name, code in _CODES.items()
        if code in value and (found := _factor(name, value[code], catalog))
    ]
    changed = {it.of[0] for it in judged if it.changes}
    for it in judged:
        # The erratum is of both: its text changes once, with the first.
        with_text = it.changes and it is next(each for each in judged if each.changes)
        yield it._replace(changes=(*it.changes, _erratum(changed))) if with_text else it


def _factor(name: str, value: Mapping[str, Any], catalog: Catalog) -> Judgement | None:
    raw, parameter = int(value["raw"]), catalog.parameter(name)
    shown = _WARM.filled(raw=raw, readings=_readings(parameter, bytes([raw])))
    if raw >= _LETTER_IS_NEUTRAL:
        return Judgement((name, "E3"), AGREES, shown)
    if not value["neutral"]:
        return None
    change = CatalogChange("parameters.toml", "parameter", name, _CHANGED[name])
    return Judgement((name, "E3"), DIFFERS, shown, (change,))


def _readings(parameter: Parameter, raw: bytes) -> Text:
    """Return `literal −0.500, alternative 0.000`, whichever of them is taken now."""
    known = parameter.interpretations
    return joined(
        ", ",
        [
            joined(" ", (text, digits(float(known[name].decode(raw)), _PLACES)))
            for name, text in READING_NAMES.items()
            if name in known and name != "corrected"
        ],
    )


def _erratum(changed: set[str]) -> CatalogChange:
    """Return the changed text of E3: the formula of each of both, and how to choose the letter."""
    taken = ". ".join(f"{name}: {_TAKEN[name][name not in changed]}" for name in _TAKEN)
    letter = "The letter: (b − 128)/256 − 0.5."
    keys = {
        "default": {"en": f"{taken}.", "ru": f"{taken}.".replace("0.5", "0,5")},
        "alternative": {"en": letter, "ru": "Буква источника: (b − 128)/256 − 0,5."},
        "selected_by": "literal",
    }
    return CatalogChange("errata.toml", "erratum", "E3", keys)


def _tair(value: int, _: Catalog) -> Iterator[Judgement]:
    yield Judgement(("E4", "TAIR"), AGREES if value == 1 else DIFFERS)


def _codes(value: Mapping[str, Any], catalog: Catalog) -> Iterator[Judgement]:
    """Compare the codes that 61 gives with those of §4; others are the unit's own."""
    sizes = {int(code, 16): int(size) for code, size in value["sizes"].items()}
    known = [each for each in catalog.parameters if each.source == "§4"]
    fits = tuple(each.name for each in known if sizes.get(each.code) == each.size)
    if fits:
        yield Judgement(fits, AGREES, _SIZES)
    for each in known:
        if each.code in sizes and sizes[each.code] != each.size:
            yield Judgement((each.name,), DIFFERS, _OTHER_SIZE.filled(size=sizes[each.code]))
    unclear = {int(code, 16) for code in value["unclear"]}
    absent = tuple(each.name for each in known if each.code not in {*sizes, *unclear})
    if fits and absent:
        yield Judgement(absent, SHOWS, _ABSENT)
    beyond: dict[int, list[str]] = {}
    for code in sorted(sizes.keys() - {code for code, _ in catalog.codes}):
        beyond.setdefault(sizes[code], []).append(f"{code:02X}")
    if beyond:
        listed = "; ".join(f"{size}: {' '.join(codes)}" for size, codes in sorted(beyond.items()))
        yield Judgement(("61",), SHOWS, _MORE.filled(codes=listed))


EVEN_OPEN: Final = frozenset({"codes", "fuel_factors"})
"""Questions whose value says something even where the answer as a whole stays open."""
JUDGES: Final[Mapping[str, Judge]] = {
    "codes": _codes,
    "freq": _freq,
    "uacc_sign": agrees("E2", "UACC"),
    "uacc_scale": _uacc,
    "fuel_factors": _factors,
    "tair": _tair,
    "valf": agrees("VALF"),
}
"""The rule of each question of a survey about parameters and errata."""
