"""Every command that reads a recording gives the true dates, and a sleep its true length."""

from __future__ import annotations

import json
import time
from datetime import UTC, datetime
from itertools import pairwise
from pathlib import Path

import pyarrow.compute as pc
import pyarrow.parquet as pq
import pytest

import mikas as library
from csv_columns import columns_of
from fleet_rig import add_here, ask
from link.network.terminal_server import ANSWER, REQUEST, served
from mikas.recording.capture.reader import CaptureReader, Packet
from mikas.recording.summary import summarise
from sampling.computer_harness import BEGAN, NIGHT, YEARS, Computer, record

CLOCK = {
    "set": {"en": "set ahead by 1460 d 0 h", "ru": "переведена вперёд на 1460 дн. 0 ч"},
    "slept": {"en": "slept for 12 h 0 min", "ru": "Компьютер спал 12 ч 0 мин"},
}


@pytest.fixture(scope="module", params=["set", "slept"])
def drive(request, tmp_path_factory) -> Path:
    """A recording in which the date was set ahead by years, or the computer slept a night."""
    path, computer = tmp_path_factory.mktemp("drives") / f"{request.param}.pcapng", Computer()
    if request.param == "set":
        computer.at(3.5, lambda: computer.jump(YEARS))
        record(path, computer)
    else:
        computer.silent(4.0, 7.0)
        computer.at(5.5, lambda: computer.jump(NIGHT))
        record(path, computer, 13.0)
    return path


@pytest.fixture
def began(drive) -> float:
    """The true time of its first values, to some seconds."""
    return BEGAN + 3 + (YEARS if drive.stem == "set" else 0)


def check_steps(drive: Path, times: list[float]) -> None:
    """The longest step is the sleep, if there was one."""
    longest = max(after - before for before, after in pairwise(times))
    assert longest == pytest.approx(NIGHT + 3 if drive.stem == "slept" else 0.2, abs=5)


def test_csv_mf4_and_parquet(mikas, drive, began, tmp_path):
    for suffix in ("csv", "mf4", "parquet"):
        ran = mikas("export", str(drive), "-o", f"a.{suffix}")
        assert ran.status == 0, ran.err
    columns = columns_of((tmp_path / "a.csv").read_text())
    pairs = zip(columns["Time"], columns["FREQ"], strict=True)
    check_steps(drive, [float(time) / 1000 for time, speed in pairs if speed])
    from asammdf import MDF  # here: its import takes 2 s

    with MDF(tmp_path / "a.mf4") as mdf:
        assert mdf.start_time.timestamp() == pytest.approx(began, abs=3)
        speed = mdf.get("FREQ")
        check_steps(drive, speed.timestamps[speed.samples > 0].tolist())
    table = pq.read_table(tmp_path / "a.parquet")
    check_steps(drive, table.filter(pc.field("FREQ") > 0)["time"].to_pylist())
    started = datetime.fromisoformat(json.loads(table.schema.metadata[b"mikas"])["started"])
    assert started.timestamp() == pytest.approx(began, abs=3)


def test_report_words_it_in_both_languages_and_has_the_date(mikas, drive, began, tmp_path):
    for language in ("en", "ru"):
        ran = mikas("report", str(drive), "-o", f"{language}.html", "--lang", language)
        assert ran.status == 0, ran.err
        page = (tmp_path / f"{language}.html").read_text(encoding="utf-8")
        assert CLOCK[drive.stem][language] in page
        assert f"{datetime.fromtimestamp(began).astimezone():%d.%m.%Y}" in page


def test_find(mikas, drive, began):
    hits = mikas("find", str(drive), "FREQ > 0", "--json").object
    assert hits["from"] == pytest.approx(began, abs=3)
    length = hits["hits"][-1]["to"] - hits["from"]
    assert length == pytest.approx(6 if drive.stem == "set" else NIGHT + 10, abs=5)


def test_the_fleet_has_the_drive_on_its_day(drive, began, tmp_path):
    assert add_here(drive, to=tmp_path / "set").added == 1
    [(first, seconds)] = ask(tmp_path / "set", "SELECT began, seconds FROM drives")
    first = first if isinstance(first, datetime) else datetime.fromisoformat(str(first))
    first = first if first.tzinfo else first.replace(tzinfo=UTC)
    assert first.timestamp() == pytest.approx(began, abs=3)
    assert seconds == pytest.approx(6 if drive.stem == "set" else NIGHT + 10, abs=5)


def test_the_list_of_recordings_and_what_the_library_gives(drive, began):
    summary, recording = summarise(drive), library.open(drive)
    assert summary.date == pytest.approx(began - 3, abs=3)
    [said] = summary.clock
    for language, words in CLOCK[drive.stem].items():
        assert words in said.to(language)
    assert summary.gaps == (drive.stem == "slept")
    times = [time for rows in recording.rows() for time in rows.times.tolist()]
    assert times[0] == pytest.approx(began, abs=3)
    check_steps(drive, times)


@pytest.mark.parametrize("seconds", [YEARS, -NIGHT])
@pytest.mark.parametrize(("command", "chunks"), [("raw 01 --yes", 99), ("doctor", 1)])
def test_a_command_with_a_capture_notes_the_date_that_was_set(
    mikas, monkeypatch, tmp_path, command, chunks, seconds
):
    real, moved = time.time, 0.0
    monkeypatch.setattr(time, "time", lambda: real() + moved)

    def unit(client):
        nonlocal moved
        for _ in range(chunks):
            data = client.recv(4096)
            client.sendall(data + ANSWER * data.count(REQUEST))
            moved = seconds

    with served(unit) as place:
        mikas(*command.split(), "--port", f"socket://{place}", "--capture", "a.pcapng")
    times = [it.time for it in CaptureReader(tmp_path / "a.pcapng") if isinstance(it, Packet)]
    assert times
    assert all(it == pytest.approx(real() + seconds, abs=3600) for it in times)
    [change] = library.open(tmp_path / "a.pcapng").events
    assert change.seconds == pytest.approx(seconds, abs=1)
