"""The data of one code in a unit's profile: their size, samples, and what they follow."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any, Final

from mikas.catalog.loading.fields import Reader, integer
from mikas.i18n import Text
from mikas.virtual.profiles.form import (
    LONGEST_DATUM,
    WrongKey,
    hex_bytes,
    list_of,
    one_of,
    read_keys,
)

MOST_SAMPLES: Final = 1000
"""The most samples of one code."""
_NO_SIZE: Final = Text("is missing", "нет этого ключа")
_OTHER_SIZE: Final = Text(
    "must have as many bytes each as size says: {size}",
    "в каждом должно быть столько байтов, сколько указано в size: {size}",
)


class Moves(Enum):
    """What the datum of a code follows, and so which of its samples a virtual unit gives."""

    CONSTANT = "constant"
    """Nothing: the first sample."""
    RPM = "rpm"
    """The engine's speed: from the first sample at standstill to the last at 3,000 rpm."""
    KEY = "key"
    """Whether the engine runs: the first sample while it stands, the last while it runs."""
    OTHER = "other"
    """Something else: a sample after the other, one a second."""


@dataclass(frozen=True, slots=True)
class CodeProfile:
    """The data of one code of a unit, as 61 gives them."""

    size: int
    """The bytes of the datum."""
    samples: tuple[bytes, ...] = ()
    """Raw data in the order that `moves` says; none: zeros."""
    moves: Moves = Moves.CONSTANT
    """What the datum follows."""

    def to_json(self) -> dict[str, Any]:
        """Return the profile of the code as JSON values."""
        samples = [sample.hex().upper() for sample in self.samples]
        return {"size": self.size, "samples": samples, "moves": self.moves.value}


_READERS: Final[Mapping[str, Reader]] = {
    "size": integer(1, LONGEST_DATUM),
    "samples": list_of(hex_bytes, MOST_SAMPLES),
    "moves": one_of(Moves),
}


def code_profile(value: object) -> CodeProfile:
    """Read the profile of a code. Raises `WrongKey`."""
    keys = read_keys(value, _READERS)
    if "size" not in keys:
        raise WrongKey("size", _NO_SIZE)
    found = CodeProfile(**keys)
    if any(len(sample) != found.size for sample in found.samples):
        raise WrongKey("samples", _OTHER_SIZE.filled(size=found.size))
    return found
