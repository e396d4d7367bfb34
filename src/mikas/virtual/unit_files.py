"""A unit's profile from a file: the ZIP of a survey, or its `unit.json` alone."""

from __future__ import annotations

import json
from pathlib import Path
from typing import BinaryIO, Final

from mikas.cleaning import clean_json
from mikas.errors import UsageError, naming_file, usage_error
from mikas.files import open_regular, too_large
from mikas.files.archives import SAVED, Archive
from mikas.virtual.unit_profile import UnitProfile

MEMBER: Final = "unit.json"
MOST_BYTES: Final = 4 << 20
"""Bytes of `unit.json`; 256 codes with as many samples each have less than 1 MB."""
_ZIP: Final = b"PK"  # the begin of every part of an archive


def load(path: Path) -> UnitProfile:
    """Read the profile in `path`. Raises `UsageError` with the file, the key and what to do."""
    with naming_file(path), open_regular(path, follow=True) as file:
        return read(file, str(path))


def read(file: BinaryIO, name: str) -> UnitProfile:
    """Read the profile in an open file. Raises `UsageError`; `UnfitFile` for a bad archive."""
    head = file.read(len(_ZIP))
    file.seek(0)
    if head == _ZIP:
        return _profile(Archive(file, SAVED).read(MEMBER, MOST_BYTES), f"{name}: {MEMBER}")
    data = file.read(MOST_BYTES + 1)
    if len(data) > MOST_BYTES:
        raise too_large(MOST_BYTES)
    return _profile(data, name)


def _profile(data: bytes, place: str) -> UnitProfile:
    try:
        value = clean_json(json.loads(data.decode()))
    except (ValueError, RecursionError) as error:
        raise _no_json(place) from error
    return UnitProfile.from_json(value, place)


def _no_json(place: str) -> UsageError:
    return usage_error(
        f"{place}: this is no JSON. A unit's profile is the ZIP that “mikas survey -o FILE.zip” "
        "writes, or the unit.json in it",
        f"{place}: это не JSON. Профиль блока — архив ZIP, который пишет «mikas survey -o "
        "ФАЙЛ.zip», или unit.json из него",
    )
