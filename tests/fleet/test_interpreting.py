"""The tables of one recording: the values of an export, cut by days, and the rest of its facts."""

from __future__ import annotations

import json
from dataclasses import replace
from datetime import date, datetime
from weakref import WeakSet

import pytest

import mikas
from drives.drive_rig import Road, Session, Unit, recorded
from fleet_rig import BEGAN, DAY, SETTINGS, add_here, ask, make
from mikas.catalog import load, shipped
from mikas.client.cars import CarDetails
from mikas.drives import trips
from mikas.fleet.interpreting import InterpretingSettings, interpret
from mikas.recording.annotations.events import car_note
from mikas.recording.capture.writer import append_note
from mikas.recording.export import export
from mikas.recording.recording import Recording

duckdb = pytest.importorskip("duckdb")


@pytest.mark.parametrize("interpretation", ["corrected", "literal"])
def test_samples_are_those_of_an_export_bit_for_bit(tmp_path, interpretation) -> None:
    file = make(tmp_path / "a" / "drive.pcapng", gap=(20.0, 25.0))
    recording = Recording(file, shipped(), interpretation)
    export(tmp_path / "a.parquet", recording.channels, recording.rows(), events=recording.events)
    settings = InterpretingSettings(shipped(), interpretation)
    add_here(tmp_path / "a", to=tmp_path / "set", settings=settings)
    wanted = duckdb.sql(f"SELECT * FROM '{tmp_path / 'a.parquet'}'")
    (parquet,) = (tmp_path / "set").glob("samples/*/*/*.parquet")
    got = duckdb.sql(
        f"SELECT * EXCLUDE (drive, utc) FROM read_parquet('{parquet}', hive_partitioning = false)"
    )
    assert got.columns == wanted.columns
    assert got.types == wanted.types
    assert got.fetchall() == wanted.fetchall()
    assert len(got) == 220  # four a second, one is the gap
    ((count,),) = ask(tmp_path / "set", "SELECT count(*) FROM samples WHERE FREQ IS NULL")
    assert count == 1


def test_a_recording_with_instruments_beside_the_unit_is_added(tmp_path) -> None:
    road = [Road(float(at), 36.0) for at in range(60)]
    unit = [Unit(at + 0.5, 1200, 7.2) for at in range(60)]
    recorded(tmp_path / "a" / "drive.pcapng", Session(unit, road))
    add_here(tmp_path / "a", to=tmp_path / "set")
    rows = ask(tmp_path / "set", "SELECT count(*), max(GPS_SPEED), max(FREQ) FROM samples")
    assert rows == [(60, 36.0, 1200.0)]


def test_a_drive_has_its_fuel_distance_and_idle_time(tmp_path) -> None:
    road = [Road(float(at), 36.0) for at in range(200)]
    unit = [Unit(at + 0.5, 1200, 7.2) for at in range(199)]
    unit[:10] = [Unit(at + 0.5, 0, 0.0) for at in range(10)]
    still = [Unit(at + 300.5, 800, 1.0, idle=True) for at in range(61)]
    file = tmp_path / "a" / "drive.pcapng"
    recording = recorded(file, Session(unit, road), Session(still), Session([Unit(500.0, 0, 0.0)]))
    add_here(tmp_path / "a", to=tmp_path / "set")
    columns = "engine_seconds, idle_seconds, litres, kilometres, litres_per_100_km"
    moving, standing, stopped = ask(
        tmp_path / "set", f"SELECT {columns} FROM drives ORDER BY seconds DESC"
    )
    assert moving == pytest.approx((188.0, 0.0, 0.376, 1.88, 20.0), rel=1e-3)
    assert standing[:2] == pytest.approx((60.0, 60.0), rel=1e-3)
    assert standing[2:] == (pytest.approx(1 / 60, rel=1e-3), None, None)
    assert stopped == (None,) * 5
    first, second = trips(recording)
    assert (moving[2], standing[2]) == pytest.approx((first.litres, second.litres), rel=1e-12)


def test_utc_is_the_time_on_the_calendar(tmp_path) -> None:
    add_here(make(tmp_path / "drive.pcapng"), to=tmp_path / "set")
    ((first, seconds, began),) = ask(
        tmp_path / "set",
        "SELECT min(utc), max(time), (SELECT began FROM drives) FROM samples",
    )
    assert first == began
    assert datetime(2026, 3, 2, 7, 30) < first < datetime(2026, 3, 2, 7, 30, 1)
    assert 59 < seconds < 60


def test_a_drive_over_midnight_lies_in_both_days(tmp_path) -> None:
    late = BEGAN - BEGAN % DAY + DAY - 30
    file = make(tmp_path / "drive.pcapng", began=late, gap=(40.0, 45.0))
    add_here(file, to=tmp_path / "set")
    rows = ask(
        tmp_path / "set", "SELECT day, count(*), min(time) FROM samples GROUP BY day ORDER BY day"
    )
    (first, before, zero), (second, after, _) = rows
    assert (first, second, zero) == (date(2026, 3, 2), date(2026, 3, 3), 0.0)
    assert before + after == 220
    assert ask(tmp_path / "set", "SELECT day FROM drives") == [(first,)]
    assert ask(tmp_path / "set", "SELECT day, seconds FROM gaps") == [(second, 5.0)]


def test_a_clock_that_does_not_count_from_1970_has_no_day(tmp_path) -> None:
    add_here(make(tmp_path / "drive.pcapng", began=100.0, faults=(13,)), to=tmp_path / "set")
    assert ask(tmp_path / "set", "SELECT DISTINCT car, day, utc FROM samples") == [
        ("A101MP52", None, None)
    ]
    assert ask(tmp_path / "set", "SELECT day, utc, code FROM faults") == [(None, None, 13)]
    assert ask(tmp_path / "set", "SELECT day, began FROM drives") == [(None, None)]


def test_faults_have_a_row_each_and_none_stored_has_one_too(tmp_path) -> None:
    add_here(make(tmp_path / "1" / "drive.pcapng", faults=(13, 12, 99)), to=tmp_path / "set")
    asked = "SELECT code, message, en IS NULL, erased, before FROM faults ORDER BY code"
    assert ask(tmp_path / "set", asked) == [
        (12, True, False, False, False),
        (13, False, False, False, False),
        (99, False, True, False, False),
    ]
    add_here(make(tmp_path / "2" / "drive.pcapng"), to=tmp_path / "other")
    assert ask(tmp_path / "other", "SELECT code, reading FROM faults") == [(None, 0)]


def test_statistics_and_alarms_are_those_of_the_report(tmp_path) -> None:
    from mikas.report.from_recording import find_in_recording

    file = make(tmp_path / "drive.pcapng", ambient=-10.0)
    add_here(file, to=tmp_path / "set")
    found = find_in_recording(mikas.open(file))
    columns = "channel, count, mean, median, low, high, least, most"
    asked = f"SELECT {columns} FROM statistics WHERE state = 'all'"
    got = {row[0]: row[1:] for row in ask(tmp_path / "set", asked)}
    for name, stats in found.measured.whole.items():
        wanted = (stats.count, stats.mean, stats.median, stats.low, stats.high)
        assert got.pop(name) == (*wanted, stats.least, stats.most)
    assert not got
    alarms = ask(tmp_path / "set", "SELECT channel, level, times, seconds, peak FROM alarms")
    assert alarms == [
        (it.limit.name, it.limit.level.value, it.times, it.seconds, it.peak)
        for it in found.measured.alarms
    ]
    assert alarms


def test_the_row_of_a_drive_has_its_facts(tmp_path) -> None:
    file = make(tmp_path / "drive.pcapng", mileage=123_456)
    add_here(file, to=tmp_path / "set")
    facts = (
        "known_by, name, plate, mileage, model, version_code, passport, fault_readings, gaps, "
        "damaged_places, virtual, file"
    )
    assert ask(tmp_path / "set", f"SELECT {facts} FROM drives") == [
        (
            "plate", "ГАЗ-3110", "а 101 мр 52", 123_456, "Mikas 7.1", "0A",
            "МИКАС 7.1 · 241.3763 · 2000.09.27", 1, 0, 0, False, "drive.pcapng",
        )
    ]  # fmt: skip


def test_sessions_appended_to_a_file_are_drives_of_their_own(tmp_path) -> None:
    first = make(tmp_path / "a.pcapng")
    second = make(tmp_path / "b.pcapng", began=BEGAN + 7200)
    both = tmp_path / "both" / "drive.pcapng"
    both.parent.mkdir()
    both.write_bytes(first.read_bytes() + second.read_bytes())
    add_here(both, to=tmp_path / "set")
    rows = ask(tmp_path / "set", "SELECT drive, recording, rows FROM drives ORDER BY began")
    (one, key, _), (two, same, _) = rows
    assert (one, two, same) == (key, f"{key}-2", key)
    asked = "SELECT drive, min(time) FROM samples GROUP BY drive ORDER BY drive"
    assert [(name, round(time)) for name, time in ask(tmp_path / "set", asked)] == [
        (one, 0),
        (two, 7200),
    ]


def test_a_gap_at_the_end_of_a_session_is_a_row_of_that_session(tmp_path) -> None:
    first = make(tmp_path / "a.pcapng", gap=(55.0, 80.0))
    second = make(tmp_path / "b.pcapng", began=BEGAN + DAY, gap=(0.0, 5.0))
    both = tmp_path / "both" / "drive.pcapng"
    both.parent.mkdir()
    both.write_bytes(first.read_bytes() + second.read_bytes())
    add_here(both, to=tmp_path / "set")
    ((key,),) = ask(tmp_path / "set", "SELECT DISTINCT recording FROM drives")
    asked = "SELECT drive, CAST(day AS VARCHAR), count(*) - count(FREQ) FROM samples GROUP BY ALL"
    assert sorted(ask(tmp_path / "set", asked)) == [
        (key, "2026-03-02", 1),
        (f"{key}-2", "2026-03-03", 1),
    ]


def sessions(path, count: int, step: float) -> None:
    """Write a file of so many sessions, each of some rows, `step` seconds apart."""
    piece = path.with_name("piece.pcapng")
    with path.open("wb") as file:
        for number in range(count):
            make(piece, seconds=3.0, began=BEGAN + number * step)
            file.write(piece.read_bytes())
    piece.unlink()


def test_each_of_many_sessions_is_a_drive_and_little_is_kept_of_it(tmp_path, monkeypatch) -> None:
    import mikas.fleet.interpreting as module

    alive, most = WeakSet(), []

    class Collector(module.MeasurementCollector):
        def __init__(self, *given) -> None:
            super().__init__(*given)
            alive.add(self)
            most.append(len(alive))

    monkeypatch.setattr(module, "MeasurementCollector", Collector)
    sessions(tmp_path / "drive.pcapng", 8, 600.0)
    add_here(tmp_path / "drive.pcapng", to=tmp_path / "set")
    asked = "SELECT count(*), count(DISTINCT drive), sum(rows), max(gaps) FROM drives"
    assert ask(tmp_path / "set", asked) == [(8, 8, 8 * 11, 0)]
    assert ask(tmp_path / "set", "SELECT count(DISTINCT drive) FROM statistics") == [(8,)]
    assert ask(tmp_path / "set", "SELECT count(DISTINCT drive) FROM samples") == [(8,)]
    assert max(most) <= 3


def test_a_clock_that_jumps_over_many_days_is_damage(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr("mikas.fleet.writing.MOST_DAYS", 2)
    sessions(tmp_path / "drive.pcapng", 2, DAY)
    assert add_here(tmp_path / "drive.pcapng", to=tmp_path / "set").added == 1
    sessions(tmp_path / "drive.pcapng", 3, DAY)
    (bad,) = add_here(tmp_path / "drive.pcapng", to=tmp_path / "set").bad
    assert "the clock is damaged" in bad.reason.en


def test_a_catalog_with_another_channel_adds_a_column(tmp_path) -> None:
    add_here(make(tmp_path / "1" / "drive.pcapng"), to=tmp_path / "set")
    own = tmp_path / "own.toml"
    own.write_text(
        '[derived.HALF]\nunit = "rpm"\nformula = "FREQ / 2"\n'
        'text = { en = "Half", ru = "Половина" }\n'
    )
    settings = InterpretingSettings(load(own))
    later = make(tmp_path / "2" / "drive.pcapng", began=BEGAN + DAY)
    add_here(later, to=tmp_path / "set", settings=settings)
    asked = "SELECT day, count(HALF), count(FREQ) FROM samples GROUP BY day ORDER BY day"
    (_, none, old), (_, halves, new) = ask(tmp_path / "set", asked)
    assert none == 0 < halves == new == old


def test_the_function_is_pure(tmp_path) -> None:
    file = make(tmp_path / "drive.pcapng", gap=(20.0, 25.0), faults=(13,))
    made = []
    for name in ("x", "y"):
        (folder := tmp_path / name).mkdir()
        it = interpret(file, "drive.pcapng", "ab" * 16, SETTINGS, folder)
        made.append({key: path.read_bytes() for key, path in it.files.items()})
    assert made[0] == made[1]
    assert {key.partition("/")[0] for key in made[0]} == {
        "samples",
        "drives",
        "statistics",
        "faults",
        "gaps",
        "alarms",
    }


def test_the_files_say_what_made_them(tmp_path) -> None:
    add_here(make(tmp_path / "drive.pcapng"), to=tmp_path / "set")
    (file,) = (tmp_path / "set").glob("samples/*/*/*.parquet")
    ((value,),) = duckdb.sql(
        f"SELECT decode(value) FROM parquet_kv_metadata('{file}') WHERE decode(key) = 'mikas'"
    ).fetchall()
    assert json.loads(value)["program"] == SETTINGS.version


def test_the_last_note_of_the_car_counts_and_a_given_name_before_it(tmp_path) -> None:
    file = make(tmp_path / "drive.pcapng")
    append_note(file, car_note(BEGAN, CarDetails(plate="Е 777 КХ 99")))
    add_here(file, to=tmp_path / "set")
    assert ask(tmp_path / "set", "SELECT car, known_by FROM drives") == [("E777KX99", "plate")]
    add_here(file, to=tmp_path / "set", settings=replace(SETTINGS, car="моя"))
    assert ask(tmp_path / "set", "SELECT car, known_by FROM drives") == [("МОЯ", "given")]
