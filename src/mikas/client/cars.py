"""The car of a unit, as its owner or a workshop names it: car, plate, mileage, workshop.

Kept in one file of the state folder, by the unit's version code and passports; the workshop is
common to all. A plate is personal data: it stands there, in the recordings and reports made with
it, and nowhere else (docs/reference/security.md).
"""

from __future__ import annotations

import re
import threading
import unicodedata
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Final

from mikas.cleaning import clean_line
from mikas.client.identity import UnitIdentity
from mikas.client.limits import unit_file
from mikas.saving import KeptFile
from mikas.virtual import VIRTUAL_PASSPORT

LONGEST: Final = 100  # characters of a field
MOST_MILEAGE: Final = 9_999_999  # km
_MOST_CARS: Final = 500
_MOST_BYTES: Final = 1 << 20
# The letters of Russian plates look like Latin ones, and are typed as either.
_LOOKALIKES: Final = str.maketrans("АВЕКМНОРСТУХ", "ABEKMHOPCTYX")


@dataclass(frozen=True, slots=True)
class CarDetails:
    """Empty or None: not given. `mileage`: km."""

    car: str = ""
    plate: str = ""
    mileage: int | None = None
    workshop: str = ""

    def __bool__(self) -> bool:
        """Whether anything is given."""
        return bool(self.car or self.plate or self.workshop) or self.mileage is not None

    @property
    def name(self) -> str:
        """Car and plate on one line; empty without them."""
        return " · ".join(filter(None, (self.car, self.plate)))

    def over(self, other: CarDetails) -> CarDetails:
        """Return these details, with those of `other` where nothing is given."""
        return CarDetails(
            self.car or other.car,
            self.plate or other.plate,
            other.mileage if self.mileage is None else self.mileage,
            self.workshop or other.workshop,
        )


def plain_plate(text: str) -> str:
    """Return a plate without spaces, in capitals and in one alphabet: `а 123 вс 52`, `A123BC52`.

    A text that is not all of letters of plates keeps its own: `Волга 2` is `ВОЛГА2`.
    """
    name = re.sub(r"[\s·-]+", "", unicodedata.normalize("NFKC", text)).upper()
    latin = name.translate(_LOOKALIKES)
    return latin if latin.isascii() else name


NO_CAR: Final = CarDetails()


def car_details(data: object) -> CarDetails:
    """Return the details in JSON or in a note: cleaned and bounded, what does not fit left out."""
    given = data if isinstance(data, dict) else {}
    car, plate, workshop = (_line(given.get(key)) for key in ("car", "plate", "workshop"))
    return CarDetails(car, plate, _km(given.get("mileage")), workshop)


def _km(value: object) -> int | None:
    if not isinstance(value, int) or isinstance(value, bool):
        return None
    return value if 0 <= value <= MOST_MILEAGE else None


def _line(value: object) -> str:
    return clean_line(value, LONGEST).strip() if isinstance(value, str) else ""


class CarBook:
    """The details of all cars, in a file; any thread may call.

    Units with empty passports can't be distinguished: such a unit has only the workshop, and so has
    a virtual unit without `virtual_units`.
    """

    def __init__(self, file: Path, *, virtual_units: bool = True) -> None:
        self.file: KeptFile[dict[str, Any]] = KeptFile(file, _MOST_BYTES, _book)
        self._virtual_units = virtual_units
        self._lock = threading.Lock()
        self._unsaved: dict[str, Any] | None = None

    def keeps(self, unit: UnitIdentity | None) -> bool:
        """Return whether the details of this unit can be kept."""
        return self._key(unit) is not None

    def details_of(self, unit: UnitIdentity | None) -> CarDetails | None:
        """Return the details of a unit; `mileage` is the last one given. None: never asked."""
        stored = self._load()
        cars, workshop = stored["cars"], _line(stored.get("workshop"))
        key = self._key(unit)
        if key is None or key not in cars:
            return None
        return replace(car_details(cars[key]), workshop=workshop)

    @property
    def workshop(self) -> str:
        """The workshop, which is common to all cars."""
        return _line(self._load().get("workshop"))

    def keep(self, unit: UnitIdentity, details: CarDetails) -> None:
        """Keep the details of a unit, also empty ones: it was asked.

        A mileage of None keeps the last one. Raises `UsageError` if they can't be saved: they stay
        as long as this book.
        """
        with self._lock:
            stored = self._load() | {"workshop": details.workshop}
            if (key := self._key(unit)) is not None:
                cars = dict(stored["cars"])
                before = car_details(cars.pop(key, None))
                kept = asdict(replace(details, mileage=details.over(before).mileage))
                del kept["workshop"]
                cars[key] = kept  # as the latest
                stored["cars"] = dict(list(cars.items())[-_MOST_CARS:])
            self._unsaved = stored
            self.file.save(stored)
            self._unsaved = None

    def _key(self, unit: UnitIdentity | None) -> str | None:
        if unit is None or unit.version_code is None or unit.passport is None:
            return None
        pieces = unit.passport.pieces
        if not any(pieces) or (VIRTUAL_PASSPORT in pieces and not self._virtual_units):
            return None
        return unit_file(Path(), unit.version_code, pieces).stem

    def _load(self) -> dict[str, Any]:
        return self._unsaved or self.file.load() or {"workshop": "", "cars": {}}


def _book(stored: object) -> dict[str, Any]:
    """Return the content of the file. Raises `TypeError`."""
    if not isinstance(stored, dict) or not isinstance(stored.get("cars"), dict):
        raise TypeError("no cars")
    return {"workshop": stored.get("workshop"), "cars": dict(stored["cars"])}
