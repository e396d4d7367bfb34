"""The file of a surveyed unit: a `UsageError` or `UnfitFile`, or a unit that can be asked.

Input: the `unit.json`, if it begins with `{`, which is then packed, so that mutations reach the
profile behind the archive's checksum; else one byte that is left out, and the archive as it is.
"""

from __future__ import annotations

import json
import zipfile
from io import BytesIO
from typing import Final

from mikas.errors import UnfitFile, UsageError
from mikas.framing import encode
from mikas.i18n import Text
from mikas.virtual.build import met_bus
from mikas.virtual.unit_files import MEMBER, read
from mikas.virtual.unit_profile import UnitProfile

NAME: Final = "survey.zip"
WORDS: Final = (
    *('{"schema": 1, ', '"codes": {"1A": {"size": 1, "samples": ["7D"], "moves": "rpm"}}'),
    *('"version_code": "0A"', '"turn_round": 1e-3', '"max_list": {"61": 1}', '"passports": null'),
    *('"strokes": {"7F": 0.5}', '"unknown": "silent"', '"missing": ["71"]', '"accepts": "raw"'),
    *('"faults": [13]', "true", "1e999", "PK\x03\x04", "PK\x01\x02", "PK\x05\x06", MEMBER),
)
_ASKED: Final = (b"\x01", b"\x02", b"\x51", b"\x60", b"\x61\x1a", b"\x71\x1a", b"\x7f\x29")


def check(data: bytes) -> None:
    packed = data[1:] if data[:1] != b"{" else _archive(data)
    try:
        profile = read(BytesIO(packed), NAME)
    except UsageError as error:
        _check_text(error.text, NAME)
        return
    except UnfitFile as error:  # the caller of `read` names the file
        _check_text(error.text, "")
        return
    written = json.loads(json.dumps(profile.to_json(), allow_nan=False))
    assert UnitProfile.from_json(written) == profile
    _ask(profile)


def _check_text(text: Text, expected: str) -> None:
    for words in text:
        assert words.strip()
        assert expected in words


def _archive(unit: bytes) -> bytes:
    out = BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(MEMBER, unit)
    return out.getvalue()


def _ask(profile: UnitProfile) -> None:
    bus = met_bus(profile)
    for number, body in enumerate(_ASKED):
        bus.send(encode(body), float(number))
        bus.collect_received(number + 0.9)
