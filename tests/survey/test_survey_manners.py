"""A survey reads only, keeps nothing of its owner, and goes on wherever it was stopped."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from survey_harness import Beside, drive, surveyed, url_of

from mikas.client.connecting import ConnectionOptions, open_ecu
from mikas.errors import UsageError
from mikas.framing import Decoder, Frame
from mikas.link.base import Direction
from mikas.recording.capture.reader import CaptureReader, Packet
from mikas.survey import Survey, SurveyOptions, Unattended, conclude
from mikas.survey.folder import SurveyFolder
from mikas.survey.recording import SurveyCapture, joined_captures
from mikas.survey.steps.commands import MEMORY, PASSPORTS

WRITING = {0x12, 0x14, 0x16, 0x22, 0x24, 0x26, 0x32, 0x41, 0x62}
STANDING = {"starts": 3000.0, "raises": 3100.0}


def requests(capture: bytes, folder: Path) -> list[bytes]:
    """The requests in a capture."""
    file = folder / "capture.pcapng"
    file.write_bytes(capture)
    bodies = []
    decoder = Decoder()
    for item in CaptureReader(file):
        if isinstance(item, Packet) and item.direction is Direction.SENT:
            bodies += [it.body for it in decoder.feed(item.data) if isinstance(it, Frame)]
    return bodies


@pytest.mark.parametrize("memory", [False, True])
def test_nothing_is_written_and_memory_is_read_with_consent_only(tmp_path, memory):
    url = url_of(drive(tmp_path), unknown="01", max_list=30)
    found = surveyed(url, tmp_path / "unit.zip", memory=memory)
    codes = {body[0] for body in requests(found.capture, tmp_path) if body}
    assert not codes & WRITING
    assert codes & MEMORY == (MEMORY if memory else set())
    assert {0x01, 0x02, 0x60, 0x61, 0x64, 0x71, 0x7F, 0x83} <= codes


def test_without_consent_no_passport_is_in_the_file(tmp_path):
    """Whether the unit has the commands is found out all the same."""
    url = url_of(drive(tmp_path, **STANDING))
    found = surveyed(url, tmp_path / "unit.zip", engine=False)
    assert not {body[0] for body in requests(found.capture, tmp_path) if body} & PASSPORTS
    assert "МИКАС".encode("cp866") not in found.capture
    assert "МИКАС" not in json.dumps([found.measured, found.unit], ensure_ascii=False)
    assert {f"{code:02X}" for code in PASSPORTS} <= set(found.unit["supported"])
    assert found.unit["passports"] is None


@pytest.mark.parametrize("passports", [False, True])
def test_blocks_of_memory_are_recorded_only_where_passports_may_be(tmp_path, passports):
    """The source does not say where the unit stores the passports' texts: a block may have them."""
    url = url_of(drive(tmp_path, **STANDING), max_list=1)
    options = {"engine": False, "memory": True, "passports": passports}
    found = surveyed(url, tmp_path / "unit.zip", **options)
    asked = requests(found.capture, tmp_path)
    assert all(limits["limit"] == 255 for limits in found.measured["blocks"].values())
    greatest = max(body[-1] for body in asked if body and body[0] in {0x21, 0x23, 0x25})
    assert greatest == (255 if passports else 2)
    swept = {body[1] for body in asked if len(body) == 2 and body[0] == 0x11}
    assert (len(swept) > 16) is passports


def test_a_thousand_runs_are_joined_in_their_order(tmp_path):
    for number in range(1, 1004):
        (tmp_path / f"capture-{number}.pcapng").write_bytes(b"%d " % number)
    capture = SurveyCapture(tmp_path, url="/dev/ttyUSB0", baud=9600, began=0.0, before=0.0)
    capture.record(Direction.SENT, b"\x01\xff\x0d", 1.0)
    capture.close()
    joined = joined_captures(tmp_path)
    assert joined.startswith(b"".join(b"%d " % number for number in range(1, 1004)))
    assert joined.endswith((tmp_path / "capture-1004.pcapng").read_bytes())


def test_the_recording_has_neither_port_nor_date(tmp_path):
    url = url_of(drive(tmp_path, **STANDING))
    found = surveyed(url, tmp_path / "unit.zip", engine=False)
    assert str(tmp_path).encode() not in (tmp_path / "unit.zip").read_bytes()
    assert str(tmp_path).encode() not in found.capture
    (tmp_path / "raw.pcapng").write_bytes(found.capture)
    items = CaptureReader(tmp_path / "raw.pcapng")
    times = [item.time for item in items if isinstance(item, Packet)]
    assert 0 <= min(times) < 5
    assert max(times) < 3600


class Killed(BaseException):
    """A program that is killed: nothing of it runs any more."""


class KilledFolder(SurveyFolder):
    """Keeps the state until the program is killed at a save."""

    left = 0

    def save(self, measured) -> None:
        KilledFolder.left -= 1
        if KilledFolder.left < 0:
            raise Killed
        super().save(measured)


@pytest.mark.parametrize("saves", [1, 3, 5, 9, 14, 20, 26])
def test_a_killed_survey_goes_on(tmp_path, monkeypatch, saves):
    """It asks what was left, and gives the answers of one that was not killed."""
    url = url_of(drive(tmp_path), max_list=12, unknown="01")
    whole = surveyed(url, tmp_path / "whole.zip")
    steps: list[str] = []
    monkeypatch.setattr("mikas.survey.survey.SurveyFolder", KilledFolder)
    KilledFolder.left = saves
    with pytest.raises(Killed):
        surveyed(url, tmp_path / "unit.zip", on_step=lambda step, *_: steps.append(step.name))
    assert not (tmp_path / "unit.zip").exists()
    KilledFolder.left = 1 << 20
    again: list[str] = []
    found = surveyed(url, tmp_path / "unit.zip", on_step=lambda step, *_: again.append(step.name))
    assert len(set(steps) & set(again)) <= 1
    assert set(steps) | set(again) >= set(whole.measured["done"])
    assert {a.id: a.verdict for a in found.answers} == {a.id: a.verdict for a in whole.answers}
    assert found.unit["max_list"] == whole.unit["max_list"]
    assert found.unit["codes"].keys() == whole.unit["codes"].keys()


def test_an_interrupted_scan_keeps_the_codes_found(tmp_path):
    """Ctrl-C in the longest step: the codes asked so far are not asked again."""
    count = 0

    def stop() -> None:
        nonlocal count
        count += 1
        if count > 250:
            raise KeyboardInterrupt

    url = url_of(drive(tmp_path, **STANDING))
    with pytest.raises(KeyboardInterrupt):
        surveyed(url, tmp_path / "unit.zip", Beside(stop=stop), engine=False)
    state = json.loads((tmp_path / "unit.zip.part" / "state.json").read_text("utf-8"))
    kept = state["measured"]["codes"]
    assert 100 < len(kept) < 256
    assert "codes" not in state["measured"]["done"]
    found = surveyed(url, tmp_path / "unit.zip", engine=False)
    assert found.measured["codes"].items() >= kept.items()
    second = found.capture.rfind(b"\x0a\x0d\x0d\x0a")
    asked = [body[1] for body in requests(found.capture[second:], tmp_path) if body[:1] == b"\x61"]
    first_pass = asked[: asked.index(0xFF) + 1]
    assert len(set(first_pass) & {int(code, 16) for code in kept}) <= len(found.unit["codes"])


def test_another_unit_does_not_go_on_with_a_survey(tmp_path):
    file = drive(tmp_path, **STANDING)
    with pytest.raises(KeyboardInterrupt):
        surveyed(url_of(file), tmp_path / "unit.zip", Beside(stop=interrupt), engine=False)
    with pytest.raises(UsageError, match=r"another unit \(0A, this one is 09\)"):
        surveyed(url_of(file, model="5.4"), tmp_path / "unit.zip", engine=False)


@pytest.mark.parametrize("port", ["serial", "sim"])
def test_a_real_unit_does_not_go_on_with_a_virtual_ones_survey(tmp_path, port):
    url, out = url_of(drive(tmp_path, **STANDING)), tmp_path / "unit.zip"
    with pytest.raises(KeyboardInterrupt):
        surveyed(url, out, Beside(stop=interrupt), engine=False)
    state = tmp_path / "unit.zip.part" / "state.json"
    kept = json.loads(state.read_text())
    assert kept["measured"]["port"] == "sim"
    kept["measured"]["port"] = port
    state.write_text(json.dumps(kept))
    if port == "sim":
        surveyed(url, out, engine=False)
        return
    with pytest.raises(UsageError, match="a virtual unit and a real one"):
        surveyed(url, out, engine=False)


def interrupt() -> None:
    raise KeyboardInterrupt


@pytest.mark.parametrize(
    "content",
    ["", "{", "[]", '{"schema": 2, "measured": {}}', '{"schema": 1, "measured": []}',
     '{"schema": 1, "measured": {}}', '{"schema": 1, "measured": {"done": 1}}',
     ('{"schema": 1, "measured": {"version_code": "0A", "done": [], "seconds": {}, '
     '"codes": {"zz": {"answer": "datum", "raw": "1"}}}}')],
)  # fmt: skip
def test_a_damaged_folder_is_said_to_be_one(tmp_path, content):
    folder = tmp_path / "unit.zip.part"
    folder.mkdir()
    (folder / "state.json").write_text(content, "utf-8")
    with (
        open_ecu(url_of(None), ConnectionOptions()) as ecu,
        pytest.raises(UsageError, match=r"no survey under way, or a damaged one\. Remove"),
    ):
        Survey(ecu, tmp_path / "unit.zip", SurveyOptions(), Unattended())


def test_a_survey_that_was_hardly_begun_has_an_answer_to_every_question(tmp_path):
    """Every question is open or not asked, with a reason."""
    with open_ecu(url_of(None), ConnectionOptions()) as ecu:
        survey = Survey(ecu, tmp_path / "unit.zip", SurveyOptions(), Unattended())
        answers = survey.answers
    assert len(answers) > 30
    assert all(answer.text.en and answer.text.ru and answer.clauses for answer in answers)
    assert {answer.id for answer in answers if answer.verdict.value == "found"} == {
        "version", "echo",
    }  # fmt: skip
    assert conclude(survey.measured) == answers


def test_an_existing_file_stays(tmp_path):
    out = tmp_path / "unit.zip"
    out.write_text("mine")
    url = url_of(drive(tmp_path, **STANDING))
    with pytest.raises(UsageError, match="exists already"):
        surveyed(url, out, engine=False)
    assert out.read_text() == "mine"


def test_the_engine_can_be_left_out_later(tmp_path):
    """It won't start: the same survey goes on without it."""
    with open_ecu(url_of(None), ConnectionOptions()) as ecu:
        first = Survey(ecu, tmp_path / "unit.zip", SurveyOptions(), Unattended())
        first.folder.save(first.measured)
        again = Survey(ecu, tmp_path / "unit.zip", SurveyOptions(engine=False), Unattended())
    assert again.goes_on
    assert again.measured["engine"] is False
