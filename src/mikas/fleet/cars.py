"""Which car a recording is of: the name of its partition, and how it is known.

In this order: the name given to `mikas fleet add`; the plate in the recording; the car's name in
it; the unit's passport; else it is unknown. A plate is the best: units with the same program have
the same passport, so a passport may stand for several cars (`KnownBy.UNIT`).
"""

from __future__ import annotations

import unicodedata
from enum import StrEnum
from hashlib import sha256
from typing import Final, NamedTuple
from urllib.parse import quote

from mikas.client.cars import CarDetails, plain_plate
from mikas.commands.unit import version_text
from mikas.recording.annotations.events import RecordedUnit
from mikas.virtual import VIRTUAL_PASSPORT

UNKNOWN: Final = "__HIVE_DEFAULT_PARTITION__"  # what the field's tools read as NULL
LONGEST: Final = 60  # characters of a name
_LONGEST_FOLDER: Final = 200  # bytes of its folder, of which systems take 255


class KnownBy(StrEnum):
    """How the car is known."""

    GIVEN = "given"
    PLATE = "plate"
    NAME = "name"
    UNIT = "unit"


class CarKey(NamedTuple):
    """The car's name in the dataset, None if unknown, and how it is known."""

    name: str | None
    known_by: KnownBy | None


def car_key(given: str, details: CarDetails, unit: RecordedUnit | None) -> CarKey:
    """Return the car of a recording."""
    for text, known_by in ((given, KnownBy.GIVEN), (details.plate, KnownBy.PLATE)):
        if name := plate_key(text):
            return CarKey(name, known_by)
    if name := _name_key(details.car):
        return CarKey(name, KnownBy.NAME)
    pieces = [piece or "" for piece in (unit.passport if unit else None) or ()]
    if unit is None or unit.version_code is None or not any(map(str.strip, pieces)):
        return CarKey(None, None)
    if VIRTUAL_PASSPORT in pieces:
        return CarKey(None, None)  # every virtual car has it
    whole = "\n".join([str(version_text(unit.version_code)), *pieces])
    return CarKey(f"unit {sha256(whole.encode()).hexdigest()[:8]}", KnownBy.UNIT)


def plate_key(text: str) -> str:
    """Return `plain_plate` of a text, cut to what a folder's name can have."""
    return _cut(plain_plate(text))


def _name_key(text: str) -> str:
    return _cut(" ".join(unicodedata.normalize("NFKC", text).casefold().split())).strip()


def _cut(name: str) -> str:
    name = name[:LONGEST]
    while len(_folder(name).encode()) > _LONGEST_FOLDER:
        name = name[:-1]
    return name


def partition(name: str | None, day: str | None) -> str:
    """Return the folders of a car and a day: `car=A123BC52/day=2026-05-09`."""
    return f"car={_folder(name)}/day={day or UNKNOWN}"


def _folder(name: str | None) -> str:
    """Return a folder's name: letters and digits of any script as they are, the rest as `%20`."""
    if not name:
        return UNKNOWN
    return "".join(it if it.isalnum() or it in "-_" else _escaped(it) for it in name)


def _escaped(character: str) -> str:
    return quote(character, safe="").replace(".", "%2E").replace("~", "%7E")
