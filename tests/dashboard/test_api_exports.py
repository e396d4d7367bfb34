"""Recordings as files: the capture, exports, the report; also of the recording in progress."""

from __future__ import annotations

import asyncio
import csv
import io
import shutil
import sys
import tempfile
from contextlib import AsyncExitStack
from pathlib import Path
from urllib.parse import quote

import pytest

import mikas
from csv_columns import columns_of
from dashboard.recordings_rig import record
from dashboard.rig import ME, OTHER, rig
from drives.drive_rig import Road, Session, Unit, recorded
from mikas.catalog.synonyms import names_of
from mikas.dashboard.api.library import files
from mikas.dashboard.library.lanes import Lane
from mikas.errors import ExportError
from mikas.i18n import Text
from mikas.report.page import policy


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return record(tmp_path_factory.mktemp("made") / "drive.pcapng", "&faults=13", count=400)


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    """Where temporary files go, so that one sees whether they went."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder


@pytest.fixture
def desk(made, tmp_path, temporary):
    folder = tmp_path / "recordings"
    folder.mkdir()
    shutil.copy(made, folder / "drive.pcapng")
    with rig(tmp_path, None) as it:
        yield it


def saved_as(answer):
    return answer.headers["content-disposition"]


def is_emptied(desk, folder):
    """Whether the folder becomes empty: an export is deleted after its last byte was sent."""
    return any(not list(folder.iterdir()) or desk.get("/state") is None for _ in range(1000))


def test_a_recording_is_downloaded_byte_for_byte(desk, made) -> None:
    answer = desk.get("/recordings/drive.pcapng/file")
    assert answer.content == made.read_bytes()
    assert answer.headers["content-type"] == "application/x-pcapng"
    assert 'filename="drive.pcapng"' in saved_as(answer)


@pytest.mark.parametrize("suffix", ["csv", "mf4", "parquet", "msl", "mlg"])
def test_every_format_is_exported_with_its_values(desk, made, temporary, tmp_path, suffix) -> None:
    answer = desk.get("/recordings/drive.pcapng/export", format=suffix, names="TWAT,FUEL_FLOW")
    assert f'filename="drive.{suffix}"' in saved_as(answer)
    assert int(answer.headers["content-length"]) == len(answer.content)
    frame = mikas.open(made).to_pandas()
    out = tmp_path / f"out.{suffix}"
    out.write_bytes(answer.content)
    assert _values(out, "TWAT") == pytest.approx(frame.TWAT.tolist(), nan_ok=True)
    assert is_emptied(desk, temporary)


def test_the_way_of_a_recording_with_a_gps_is_exported_and_else_refused(desk, tmp_path) -> None:
    road = [Road(float(at), 36.0, 56 + at / 1000, 44.0) for at in range(5)]
    unit = [Unit(at + 0.5, 1200, 7.2) for at in range(5)]
    recorded(tmp_path / "recordings" / "way.pcapng", Session(unit, road))
    answer = desk.get("/recordings/way.pcapng/export", format="gpx", names="JQT")
    assert answer.headers["content-type"] == "application/gpx+xml"
    assert 'filename="way.gpx"' in saved_as(answer)
    assert answer.content.count(b"<mikas:JQT>7.2</mikas:JQT>") == 5
    answer = desk.get("/recordings/way.pcapng/export", format="geojson")
    assert len(answer["features"]) == 5 + 1
    error = desk.get("/recordings/drive.pcapng/export", 400, format="gpx")
    assert error["code"] == "ExportError"
    assert "there is no position in this recording" in error["en"]


def _values(out: Path, name: str) -> list[float]:
    match out.suffix:
        case ".csv":
            rows = list(csv.reader(io.StringIO(out.read_text("utf-8-sig"))))
            column = next(at for at, cell in enumerate(rows[0]) if name in cell)
            return [float(row[column] or "nan") for row in rows[1:]]
        case ".mf4":
            from asammdf import MDF

            with MDF(out) as file:
                return file.get(name).samples.tolist()
        case ".parquet":
            import pyarrow.parquet

            return pyarrow.parquet.read_table(out).column(name).to_pandas().tolist()
        case ".msl":
            lines = [line.split("\t") for line in out.read_text("utf-8").splitlines()]
            head = next(at for at, cells in enumerate(lines) if cells[0] == "Time")
            column = lines[head].index(names_of(name).log)
            return [float(cells[column]) for cells in lines[head + 2 :] if len(cells) > column]
    assert out.read_bytes()[:6] == b"MLVLG\0"
    return mikas.open(out.parent / "recordings/drive.pcapng").to_pandas()[name].tolist()


def test_what_happened_is_in_the_export(desk) -> None:
    answer = desk.get("/recordings/drive.pcapng/export", format="msl", lang="ru")
    marks = [line for line in answer.text.splitlines() if line.startswith("MARK")]
    assert marks == ["MARK 000 - here", "MARK 001 - разрыв 0,1 с: нет эха"]


def test_an_export_for_a_spreadsheet_has_all_channels(desk, made) -> None:
    answer = desk.get("/recordings/drive.pcapng/export", dialect="excel", lang="ru")
    text = answer.content.decode("utf-8-sig")
    assert "Температура" in text.splitlines()[0]
    assert {channel.name for channel in mikas.open(made).channels} <= set(columns_of(text, ";"))


def test_exports_that_can_not_be_made_leave_nothing(desk, temporary) -> None:
    for query in ({"format": "xls"}, {"names": "TWATT"}, {"names": "0x1A"}, {"dialect": "?"}):
        assert desk.get("/recordings/drive.pcapng/export", 400, **query)["ru"]
    assert is_emptied(desk, temporary)


@pytest.mark.parametrize(("suffix", "library"), [("mf4", "asammdf"), ("parquet", "duckdb")])
def test_a_missing_extra_is_an_error_with_its_command(
    desk, temporary, monkeypatch, suffix, library
) -> None:
    monkeypatch.setitem(sys.modules, library, None)
    error = desk.get("/recordings/drive.pcapng/export", 400, format=suffix)
    assert error["code"] == "MissingExtra"
    assert 'pip install "mikas[' in error["en"]
    assert 'pip install "mikas[' in error["ru"]
    assert is_emptied(desk, temporary)


def test_a_name_of_any_letters_arrives_as_it_is(desk) -> None:
    folder = desk.dashboard.settings.recordings
    name = "Волга 24, 100%.pcapng"
    (folder / "drive.pcapng").rename(folder / name)
    path = f"/recordings/{quote(name)}"
    assert desk.get(path)["id"] == name
    for what in ("/file", "/export", "/report"):
        assert quote(name.removesuffix(".pcapng"), safe="") in saved_as(desk.get(path + what))


def test_one_file_is_exported_once_at_a_time(desk, monkeypatch) -> None:
    from concurrent.futures import ThreadPoolExecutor
    from threading import Lock

    from mikas.recording.export import export as write

    here, most, lock = [], [], Lock()

    def watched(*args, **settings):
        with lock:
            here.append(1)
            most.append(len(here))
        try:
            return write(*args, **settings)
        finally:
            here.pop()

    monkeypatch.setattr("mikas.recording.export.export", watched)
    with ThreadPoolExecutor(6) as pool:
        ask = "/recordings/drive.pcapng/export"
        for done in [pool.submit(desk.get, ask, format="csv") for _ in range(6)]:
            done.result()
    assert most == [1] * 6


def test_a_queue_that_is_too_long_is_refused(desk, monkeypatch) -> None:
    from concurrent.futures import ThreadPoolExecutor
    from threading import Event, Semaphore

    go, asked = Event(), Semaphore(0)
    run = Lane.run

    async def counted(self, *args, **settings):
        asked.release()
        return await run(self, *args, **settings)

    def waits(*_, **__):
        assert go.wait(60)
        raise ExportError("a", Text("so be it", "пусть так"))

    monkeypatch.setattr(Lane, "run", counted)
    monkeypatch.setattr("mikas.recording.export.export", waits)
    path = "/api/recordings/drive.pcapng/export"
    with ThreadPoolExecutor(8) as pool:
        waiting = [pool.submit(desk.client.get, path, headers=ME) for _ in range(8)]
        for _ in range(8):
            assert asked.acquire(timeout=60)
        assert desk.get("/recordings/drive.pcapng/export", 409)["code"] == "Busy"
        assert desk.get("/recordings/drive.pcapng/report", 409)["code"] == "Busy"
        go.set()
        assert {each.result().status_code for each in waiting} == {400}
    monkeypatch.undo()
    assert desk.get("/recordings/drive.pcapng/export").content


def test_nothing_is_left_after_the_client_has_gone(temporary) -> None:
    folder = Path(tempfile.mkdtemp())
    (folder / "a.csv").write_text("x" * 1000)
    resources = AsyncExitStack()
    resources.push_async_callback(files._delete, folder)  # noqa: SLF001
    answer = files._Temporary(folder / "a.csv", resources, filename="a.csv")  # noqa: SLF001

    async def gone(_) -> None:
        raise OSError("the other side is gone")

    async def receive():
        return {"type": "http.disconnect"}

    scope = {"type": "http", "method": "GET", "headers": []}
    with pytest.raises(OSError, match="gone"):
        asyncio.run(answer(scope, receive, gone))
    assert is_emptied(desk, temporary)


# --- the report


def test_the_report_of_a_recording_is_a_page_in_the_language(desk) -> None:
    answer = desk.get("/recordings/drive.pcapng/report", lang="ru")
    assert answer.headers["content-type"].startswith("text/html")
    assert "drive.html" in saved_as(answer)
    assert "attachment" in saved_as(answer)
    assert "Отчёт о двигателе" in answer.text
    assert "В памяти блока 1 ошибка: 13;" in answer.text
    assert "Engine report" in desk.get("/recordings/drive.pcapng/report").text
    assert desk.get("/recordings/drive.pcapng/report", 400, lang="de")["ru"]


def test_the_inline_report_runs_in_a_sandbox_without_scripts(desk) -> None:
    answer = desk.get("/recordings/drive.pcapng/report", inline=1)
    assert "content-disposition" not in answer.headers
    policy_sent = answer.headers["content-security-policy"]
    assert policy_sent.startswith(policy())
    assert "frame-ancestors 'self'" in policy_sent
    assert policy_sent.endswith("; sandbox allow-same-origin allow-modals")
    assert "script" not in policy_sent
    assert answer.headers["x-frame-options"] == "SAMEORIGIN"
    assert "unsafe" not in policy_sent


def test_without_a_connection_there_is_no_live_report(desk) -> None:
    assert desk.get("/report", 503)["code"] == "NotConnected"


# --- the running connection


@pytest.fixture
def idle(tmp_path, temporary):
    names = ("FREQ", "TWAT", "THR", "UACC", "JAIR", "INJ", "FUEL_FLOW", "RXX")
    with rig(tmp_path, "sim:?scenario=warm-idle&faults=13", names=names) as it:
        it.sampling()
        yield it


def report_with(idle, wanted: str) -> str:
    """The live report, once it says so: a busy machine has its ten seconds of idle later."""
    text = ""
    for _ in range(50):
        began = idle.dashboard.connection.now()
        idle.until(lambda it, began=began: it["now"] > began + 14)
        text = idle.get("/report", lang="ru").text
        if wanted in text:
            break
    assert wanted in text
    return text


def test_the_live_report_has_the_values_and_faults_of_the_unit(idle) -> None:
    idle.until(lambda it: it["state"]["fault_count"] == 1)
    text = report_with(idle, "все значения, которые можно оценить (5)")
    assert "измерено на виртуальном автомобиле" in text
    assert "В памяти блока 1 ошибка: 13;" in text
    assert "МИКАС 7.1" in text
    assert "несколько параметров одним запросом" in text
    answer = idle.get("/report", inline=1)
    assert "content-disposition" not in answer.headers
    assert "mikas.html" in saved_as(idle.get("/report"))


def erase(idle) -> None:
    idle.until(lambda it: it["state"]["fault_count"] == 1)
    nonce = idle.post("/changes", {"kind": "erase_faults"})["nonce"]
    assert idle.post(f"/changes/{nonce}", headers=ME)["after"] == []


def test_the_live_report_names_the_erased_faults(idle) -> None:
    began = idle.dashboard.connection.now()
    erase(idle)
    idle.until(lambda it: it["now"] > began + 20)
    text = idle.get("/report").text
    assert "verdict open" in text
    assert "No problems found" not in text
    assert "fault 13 was erased at" in text
    assert "read the faults again" in text


def test_a_recording_started_in_mid_session_knows_the_faults_read_before(idle) -> None:
    idle.until(lambda it: it["state"]["fault_count"] == 1)
    idle.post("/recording/start", {"name": "now"})
    idle.until(lambda it: it["state"]["recording"]["samples"] > 20)
    idle.post("/recording/stop")
    text = idle.get("/recordings/now.pcapng/report").text
    assert "1 fault is stored: 13;" in text
    assert "Read at " in text


def test_a_recording_started_after_erasing_says_so(idle) -> None:
    erase(idle)
    idle.post("/recording/start", {"name": "now"})
    idle.until(lambda it: it["state"]["recording"]["samples"] > 20)
    idle.post("/recording/stop")
    text = idle.get("/recordings/now.pcapng/report", lang="ru").text
    assert "; ошибка 13 сброшена в " in text
    assert "verdict open" in text


def test_the_recording_in_progress_is_listed_read_and_exported(idle) -> None:
    idle.post("/recording/start", {"name": "now"})
    idle.until(lambda it: it["state"]["recording"]["samples"] > 20)
    (it,) = idle.get("/recordings")["recordings"]
    assert (it["id"], it["open"], it["problem"]) == ("now.pcapng", True, None)
    assert it["date"] > 1e9
    recorded = idle.get("/recordings/now.pcapng/rows", names="TWAT")["values"][0]
    live = idle.get("/history", seconds=3600, points=20000, names="TWAT")["values"][0]
    assert set(recorded) <= {*live, None}
    assert all(value is None or 86 <= value <= 95 for value in recorded)  # warm, by the thermostat
    assert idle.get("/recordings/now.pcapng")["open"] is True
    answer = idle.get("/recordings/now.pcapng/file")
    assert int(answer.headers["content-length"]) == len(answer.content)
    assert len(answer.content) > 1000
    note = idle.put("/recordings/now.pcapng/note", {"text": "идёт"})["note"]
    assert note in ("идёт", "")  # it may not be on the disk yet
    wish = {"kind": "delete_recording", "id": "now.pcapng"}
    assert idle.post("/changes", wish, 409)["code"] == "Busy"
    idle.post("/recording/stop")
    after = idle.get("/recordings/now.pcapng")
    assert (after["open"], after["note"]) == (False, "идёт")
    assert "Engine report" in idle.get("/recordings/now.pcapng/report").text
    nonce = idle.post("/changes", wish)["nonce"]
    idle.post(f"/changes/{nonce}", headers=ME)
    assert idle.get("/recordings")["recordings"] == []


def test_a_recording_that_was_confirmed_and_then_goes_on_is_not_deleted(idle) -> None:
    folder = idle.dashboard.settings.recordings
    idle.post("/recording/start", {"name": "a"})
    idle.post("/recording/stop")
    nonce = idle.post("/changes", {"kind": "delete_recording", "id": "a.pcapng"})["nonce"]
    (folder / "a.pcapng").unlink()
    idle.post("/recording/start", {"name": "a"})
    assert idle.post(f"/changes/{nonce}", status=409)["code"] in ("Busy", "ConfirmationOutdated")
    assert (folder / "a.pcapng").exists()


def test_a_viewer_may_read_and_take_away_but_not_note_or_delete(made, tmp_path) -> None:
    folder = tmp_path / "recordings"
    folder.mkdir()
    shutil.copy(made, folder / "drive.pcapng")
    with rig(tmp_path, None) as it:
        it.post("/control/take", {"force": True}, headers=OTHER)
        assert it.get("/recordings")["recordings"]
        assert it.get("/recordings/drive.pcapng/report").text
        wish = {"kind": "delete_recording", "id": "drive.pcapng"}
        assert it.post("/changes", wish, 409)["code"] == "NotController"
