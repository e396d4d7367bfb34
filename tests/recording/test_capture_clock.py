"""Times that no recording has are refused where they are read; the length of the others costs
nothing.
"""

from __future__ import annotations

import pytest
from crafted_harness import MICRO, PORT, SECTION, calls, exchange, packet

import mikas
from mikas.catalog import shipped
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.clock import LONGEST, RecordingClock
from mikas.recording.capture.reader import CaptureReader, Packet, Problem
from mikas.recording.exchanges.columns.matcher import column_exchanges
from mikas.recording.exchanges.turns import quick_exchanges
from mikas.recording.export import SUFFIXES, export
from mikas.recording.inspect import decode, to_text
from mikas.recording.summary import summarise
from mikas.replay import load
from mikas.report.from_recording import find_in_recording
from mikas.report.page import render

TODAY = 1_790_000_000.0
YEARS = 0.9 * LONGEST
NEAR_2_64 = ((1 << 64) - 7) / MICRO


def capture(path, *parts):
    path.write_bytes(SECTION + PORT + b"".join(parts))
    return path


def drive(count, begin, step):
    return (exchange(b"\x61\x1a", b"\x50", begin + number * step) for number in range(count))


def accepted(*times):
    clock, found = RecordingClock(), []
    for time in times:
        clock, is_possible = clock.after_packet(time)
        found += [time] * is_possible
    return found


def test_a_clock_from_0_one_before_0_and_a_real_one_stay_and_may_jump_for_years():
    for times in ((0, 1, 2), (-5, 0, 5), (TODAY, TODAY - 9, TODAY + YEARS, TODAY), (1, YEARS, 0)):
        assert accepted(*times) == list(times)


def test_a_time_without_a_date_or_far_from_the_others_is_refused():
    far = TODAY + 2 * LONGEST
    assert accepted(TODAY, TODAY, NEAR_2_64, far, -LONGEST, TODAY, far, far) == [TODAY] * 3
    assert accepted(float("nan"), float("inf"), -1e18, 3, 4) == [3, 4]
    # A wrong first one, or a wrong second one: the third decides.
    assert accepted(far, 1, 2, far, 3) == [far, 2, 3]
    assert accepted(1, far, 2, far, 3) == [1, 2, 3]


def test_a_packet_with_an_impossible_time_is_a_problem_that_shows_its_bytes(tmp_path):
    parts = [*drive(2, TODAY, 0.1), *drive(1, NEAR_2_64 - 1, 0), *drive(3, TODAY + 0.2, 0.1)]
    path = capture(tmp_path / "a.pcapng", *parts)
    items = list(CaptureReader(path))
    problems = [item for item in items if isinstance(item, Problem)]
    good = len(SECTION + PORT + parts[0] + parts[1])
    assert [each.offset for each in problems] == [good, good + len(packet(b"\x61\x1a"))]
    lines = [to_text(item) for item in decode(items)]
    assert sum("time; its bytes: 61 1A 85 0D" in line for line in lines) == 1
    assert sum("time; its bytes: 50 B0 0D" in line for line in lines) == 1
    times = [item.time for item in items if isinstance(item, Packet)]
    assert (len(times), min(times), max(times)) == (10, TODAY, TODAY + 0.41)

    turns, columns = (
        list(each(path, shipped().size_of)) for each in (quick_exchanges, column_exchanges)
    )
    assert [it for it in turns if isinstance(it, Problem)] == problems
    assert [it for it in columns if isinstance(it, Problem)] == problems
    assert sum(len(it.responses.times) for it in columns if not isinstance(it, Problem)) == 5
    rows = [time for rows in mikas.open(path).rows() for time in rows.times.tolist()]
    assert len(rows) == 5
    assert TODAY <= min(rows) <= max(rows) < TODAY + 1
    assert summarise(path).length == pytest.approx(0.41)


def exported(path, out, *suffixes):
    recording = mikas.open(path)
    for suffix in suffixes:
        export(
            out.with_suffix(suffix), recording.channels, recording.rows(), overwrite=True,
            events=recording.events, about=recording.about,
        )  # fmt: skip


def everything(path, out):
    """Make all of a recording that costs the same for each format."""
    exported(path, out, ".csv", ".msl")
    recording = mikas.open(path)
    recording.window(*recording.span, points=10)
    summarise(path, shipped())
    render(find_in_recording(mikas.open(path)), "ru")
    assert load(path).duration < 3600


def work_of(path, parts):
    capture(path, *parts)
    return calls(lambda: everything(path, path.with_suffix(".x")))


def test_a_clock_that_is_set_from_1970_to_today_loses_nothing():
    assert accepted(3, 4, TODAY, TODAY + 1, 5) == [3, 4, TODAY, TODAY + 1, 5]


def test_a_lifetime_costs_no_more_than_a_month(tmp_path):
    path = tmp_path / "a.pcapng"
    work_of(path, drive(2, TODAY, 0.2))  # imports, the catalog
    month, years = (work_of(path, drive(12, TODAY, step)) for step in (2e5, YEARS / 12))
    assert years <= 1.1 * month
    # Also with a date beyond those that a format can hold.
    capture(path, *drive(3, 2e11, YEARS / 3))
    exported(path, tmp_path / "b.x", *SUFFIXES)


def test_a_clock_that_runs_to_and_fro_costs_in_proportion_to_its_packets(tmp_path):
    to_and_fro = [exchange(b"\x61\x1a", b"\x50", TODAY + 1e6 * (n % 2)) for n in range(10)]
    once, twice = (work_of(tmp_path / "a.pcapng", to_and_fro * times) for times in (1, 2))
    assert twice <= 2.2 * once


def test_resolutions_and_offsets_of_any_value_make_no_endless_time(tmp_path):
    for tsresol in (0, 1, 30, 127, 128, 128 + 63, 255):
        for tsoffset in (-(1 << 63), -1, 0, 1, 1 << 33, (1 << 63) - 1):
            port = pcapng.encode(pcapng.Interface(tsresol=tsresol, tsoffset=tsoffset))
            path = tmp_path / "a.pcapng"
            path.write_bytes(SECTION + port + b"".join(drive(2, TODAY, 0.1)))
            times = [item.time for item in CaptureReader(path) if isinstance(item, Packet)]
            assert all(-LONGEST <= time < 2.6e11 for time in times)
            list(mikas.open(path).rows())
