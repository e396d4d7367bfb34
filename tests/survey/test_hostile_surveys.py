"""A survey's ZIP that somebody has made or damaged: it is refused, and what is wrong is named."""

from __future__ import annotations

import io
import json
import zipfile

import pytest

from mikas.errors import UsageError
from mikas.survey import SurveyFile, read_survey
from mikas.survey.archive import archive
from mikas.virtual.unit_profile import UnitProfile

CONTENT = SurveyFile((), {"done": []}, UnitProfile().to_json(), {"mikas": "0.1.0"}, b"raw")
WHOLE = archive(CONTENT, "ru, en")
NAMES = ("README.txt", "survey.json", "unit.json", "capture.pcapng")


def changed(**members: bytes | None) -> bytes:
    """The ZIP with other members; None leaves one out."""
    out = io.BytesIO()
    with (
        zipfile.ZipFile(io.BytesIO(WHOLE)) as before,
        zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as after,
    ):
        for name in NAMES:
            data = members.get(name.partition(".")[0], before.read(name))
            if data is not None:
                after.writestr(name, data)
    return out.getvalue()


def damaged(name: str) -> bytes:
    """The ZIP with another first byte of what is packed of a member."""
    data = bytearray(WHOLE)
    data[WHOLE.index(name.encode()) + len(name)] ^= 0xFF
    return bytes(data)


def survey(**keys: object) -> bytes:
    whole = {"schema": 1, "answers": [], "measured": {}, "versions": {}}
    return json.dumps(whole | keys).encode()


def test_a_whole_one_is_read(tmp_path):
    path = tmp_path / "unit.zip"
    path.write_bytes(WHOLE)
    assert read_survey(path) == CONTENT
    path.write_bytes(changed())
    assert read_survey(path) == CONTENT


WRONG = {
    "no ZIP": (b"hello", "no ZIP archive"),
    "cut": (WHOLE[:-9], "no ZIP archive"),
    **{
        f"no {name}": (
            changed(**{name.partition(".")[0]: None}),
            f"no {name}: it must be the ZIP that “mikas survey -o FILE.zip” has saved",
        )
        for name in NAMES
    },
    "bomb": (changed(unit=b" " * ((1 << 22) + 1)), "unit.json in the archive unpacks to more"),
    "damaged": (damaged("capture.pcapng"), "capture.pcapng in the archive is damaged"),
    "newer": (changed(survey=survey(schema=2)), "another version"),
    "deep": (changed(survey=b"[" * 50_000), "no survey's ZIP"),
    "no object": (changed(survey=survey(measured=[])), "no survey's ZIP"),
    "answers": (changed(survey=survey(answers=[{}])), "which “mikas survey"),
    "no text": (changed(unit=b"\xff"), "no survey's ZIP"),
    "infinite": (changed(unit=b'{"turn_round": 1e999}'), "no survey's ZIP"),
}


@pytest.mark.parametrize("kind", WRONG)
def test_a_wrong_one_is_refused_with_what_is_wrong(kind, tmp_path):
    data, expected = WRONG[kind]
    path = tmp_path / "unit.zip"
    path.write_bytes(data)
    with pytest.raises(UsageError) as caught:
        read_survey(path)
    en, ru = caught.value.text
    assert en.startswith(str(path))
    assert expected in en
    assert str(path) in ru
    assert en != ru
