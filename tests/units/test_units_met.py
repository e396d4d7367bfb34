"""Every unit that was met, on a virtual wire: it is connected to, read whole, and streamed.

None lies here yet (README.md), so a survey-like profile of an odd unit of our own is asked as well:
what a real one will be asked works.
"""

from __future__ import annotations

import json
import re
import zipfile
from pathlib import Path

import pytest

import mikas
from mikas.client import Answer
from mikas.errors import NotSupported
from mikas.link.virtual import VirtualLink
from mikas.virtual.build import met_bus
from mikas.virtual.quirks import BadWrite, ChecksumForm, LongList, StreamEnd
from mikas.virtual.unit_files import MOST_BYTES, load
from mikas.virtual.unit_profile import CodeProfile, Moves, UnitProfile

FOLDER = Path(__file__).parent
PAGES = [FOLDER.parents[1] / "docs" / at / "reference" / "units-met.md" for at in ("", "ru")]
FILES = sorted(path for path in FOLDER.iterdir() if path.suffix not in (".py", ".md", ""))
NAME = re.compile(r"(mikas-(5\.4|7\.1)|unknown-[0-9A-F]{2})-[1-9]\d*\.json")
OWN = UnitProfile(
    version_code=0x2C,
    echo=False,
    turn_round=0.021,
    turn_round_spread=0.003,
    inter_byte=0.0008,
    missing=frozenset({0x60, 0x63, 0x64, 0x41, 0x53}),
    unknown="01",
    bad_write=BadWrite.SILENT,
    max_list_61=3,
    max_list_71=2,
    long_list=LongList.SHORT,
    accepts=ChecksumForm.STUFFED,
    sends=ChecksumForm.RAW,
    stream_end=StreamEnd.REQUEST,
    stream_gap=0.004,
    stream_load=1.5,
    codes={
        0x1A: CodeProfile(1, (b"\x7d",)),
        0x29: CodeProfile(1, (b"\x15", b"\x16"), Moves.RPM),
        0x3F: CodeProfile(2, (b"\x58\x02",), Moves.OTHER),
        0x40: CodeProfile(1, (b"\x40",)),  # of another size than §4's
        0x90: CodeProfile(3, (b"\x00\x00\x00", b"\x01\x02\x03"), Moves.KEY),
    },
    passports=("ОСОБЫЙ", "", None, *[""] * 5),
    faults=(13, 13, 53),
)


@pytest.fixture(params=[*FILES, OWN], ids=[*(path.name for path in FILES), "our own"])
def profile(request) -> UnitProfile:
    return request.param if isinstance(request.param, UnitProfile) else load(request.param)


@pytest.fixture
def ecu(profile):
    with mikas.connect(VirtualLink(met_bus(profile))) as connected:
        yield connected


def test_it_is_connected_to_and_says_what_it_is(ecu, profile):
    info = ecu.info()
    if profile.version_code is not None:
        assert info.version_code == profile.version_code
    if profile.echo is not None:
        assert info.echo is profile.echo
    if profile.parameter_count is not None and 0x60 not in profile.missing:
        assert info.parameter_count == profile.parameter_count
    if 0x60 in profile.missing:
        assert info.parameter_count is None
    read = (*info.passport.program, *info.passport.data)
    for at, text in enumerate(profile.passports or ()):
        if text is not None and 0x51 + at not in profile.missing:
            assert read[at] == text


def test_its_faults_are_read(ecu, profile):
    if 0x02 in profile.missing:
        pytest.skip("this unit has no command for faults")
    stored = profile.faults or ()
    assert sorted({fault.code for fault in ecu.faults()}) == sorted(set(stored))


def test_a_scan_finds_its_codes_with_their_sizes(ecu, profile):
    if profile.codes is None or 0x61 in profile.missing:
        pytest.skip("its codes were not found out")
    found = {each.code: each.size for each in ecu.scan() if each.answer is Answer.DATUM}
    assert found == {code: each.size for code, each in profile.codes.items()}


def known_to(profile: UnitProfile, ecu: mikas.Ecu) -> list[str]:
    """The names of the parameters of which the unit has the code and the size."""
    return [
        parameter.name
        for parameter in ecu.catalog.parameters
        if profile.codes is None
        or (
            parameter.code in profile.codes and profile.codes[parameter.code].size == parameter.size
        )
    ]


def test_every_parameter_of_it_is_read(ecu, profile):
    names = known_to(profile, ecu)
    assert names
    readings = ecu.read(*names)
    assert [*readings] == names
    for parameter in ecu.catalog.parameters:
        if parameter.name in names:
            assert len(readings[parameter.name].raw) == parameter.size
        elif parameter.code not in (profile.codes or {}):
            with pytest.raises(NotSupported):
                ecu.read(parameter.name)


def test_it_is_streamed_and_answers_after_that(ecu, profile):
    if 0x71 in profile.missing:
        pytest.skip("this unit has no stream")
    names = known_to(profile, ecu)[: profile.max_list_71]
    with ecu.stream(*names) as responses:
        for _ in range(20):
            assert [*next(responses)] == names
    if profile.version_code is not None:
        assert ecu.info().version_code == profile.version_code


# Rules


def broken_rules(path: Path, readme: str) -> list[str]:
    """The rules of README.md that a file breaks."""
    rules = {
        "the name": NAME.fullmatch(path.name) is not None,
        "its size": path.stat().st_size <= MOST_BYTES,
        "unit.json alone": path.read_bytes()[:1] == b"{",
        "passports": load(path).passports is None or f"| `{path.name}` | agreed |" in readme,
    }
    return [name for name, is_kept in rules.items() if not is_kept]


def test_every_file_keeps_the_rules():
    readme = (FOLDER / "README.md").read_text("utf-8")
    assert {path.name: broken_rules(path, readme) for path in FILES} == {
        path.name: [] for path in FILES
    }


def test_the_rules_refuse_what_they_forbid(tmp_path):
    shy = json.dumps(UnitProfile(version_code=0x2C).to_json())
    open_hearted = json.dumps(OWN.to_json())
    path = tmp_path / "unknown-2C-1.json"
    path.write_text(shy, "utf-8")
    assert broken_rules(path, "") == []
    path.write_text(open_hearted, "utf-8")
    assert broken_rules(path, "") == ["passports"]
    assert broken_rules(path, "| `unknown-2C-1.json` | agreed |") == []
    for name in ("a123bc-52.json", "mikas-7.1-01.json", "mikas-7.2-1.json", "mikas-7.1-1.zip"):
        other = path.rename(tmp_path / name)
        assert "the name" in broken_rules(other, f"| `{name}` | agreed |")
        other.rename(path)
    with zipfile.ZipFile(tmp_path / "mikas-7.1-1.json", "w") as archive:
        archive.writestr("unit.json", shy)
    assert broken_rules(tmp_path / "mikas-7.1-1.json", "") == ["unit.json alone"]


def test_nothing_else_lies_here():
    assert {path.name for path in FOLDER.iterdir()} - {path.name for path in FILES} <= {
        "README.md", "test_units_met.py", "__pycache__"
    }  # fmt: skip


@pytest.mark.parametrize("page", PAGES, ids=["en", "ru"])
def test_the_page_has_a_row_for_each_and_says_so_while_there_is_none(page):
    text = page.read_text("utf-8")
    rows = re.findall(r"^\| `([\w.-]+\.json)` \|", text, re.MULTILINE)
    assert sorted(rows) == [path.name for path in FILES]
    assert ("**None yet.**" in text or "**Пока ни одного.**" in text) is (not FILES)
