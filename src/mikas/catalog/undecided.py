"""The other readings of a parameter whose letter is odd but possible (E3): only a car decides.

    otherwise(RCOK) ──► {"alternative": Conversion, "family": Conversion}

They stand beside the value wherever it is shown. A letter that is impossible (E1, E2) is not among
them: there the correction is certain.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from mikas.catalog.conversion import Conversion
from mikas.catalog.model import Parameter
from mikas.i18n import Text

READING_NAMES: Final[Mapping[str, Text]] = {
    "literal": Text("literal", "буквально"),
    "alternative": Text("alternative", "иначе"),
    "family": Text("family", "как у родственных"),
    "corrected": Text("corrected", "исправлено"),
}
"""Each interpretation in a word; of equal ones the first names them."""


def otherwise(parameter: Parameter, interpretation: str = "corrected") -> dict[str, Conversion]:
    """Return the other readings of an undecided parameter, by name; of another one none.

    `interpretation`: the one that is used.
    """
    if not (parameter.alternative or parameter.family):
        return {}
    used, known = parameter.interpretation(interpretation), parameter.interpretations
    found: dict[str, Conversion] = {}
    for name in READING_NAMES:
        each = known.get(name, used)
        if each != used and each not in found.values():
            found[name] = each
    return found


def values_otherwise(
    parameter: Parameter, raw: bytes, interpretation: str = "corrected"
) -> dict[str, float]:
    """Return what `raw` is by each of these readings."""
    others = otherwise(parameter, interpretation)
    return {name: each.decode(raw) for name, each in others.items()}
