"""`mikas.session`: samples, all events, listeners, the recording, an adapter that comes back."""

from __future__ import annotations

import asyncio
import os
import queue
import sys
from contextlib import suppress
from functools import partial

import pytest

import mikas
from mikas import errors
from mikas.recording.recorder import Recorder
from mikas.sampling.events import (
    AlarmChanged,
    Event,
    FaultReading,
    Gap,
    Sampled,
    StateChanged,
    UnitFound,
)

SIM = "sim:?clock=simulated"


class TestSamples:
    def test_have_the_channels_derived_ones_and_rare_ones(self, on_unit):
        samples = list(on_unit(["FREQ", "TWAT/10", "FUEL_FLOW"], count=40, method="batch"))
        assert len(samples) == 40
        assert all({"FREQ", "FUEL_FLOW"} <= sample.values.keys() for sample in samples)
        assert 0 < sum("TWAT" in sample.values for sample in samples) < 20
        assert samples[-1].time > samples[0].time

    def test_end_after_a_duration(self, on_unit):
        samples = list(on_unit(["FREQ"], duration=10, method="batch"))
        assert samples[-1].time - samples[0].time == pytest.approx(10, abs=0.5)

    def test_end_after_a_duration_also_while_no_unit_answers(self, on_unit, unit):
        session = on_unit(["FREQ"], duration=10, method="batch")
        next(session)
        unit.turn_key(on=False)
        events = list(session.events())
        assert events[-1].time - events[0].time == pytest.approx(10, abs=2)
        assert session.progress.failed_cycles > 0
        assert session.line_errors > 0

    @pytest.mark.parametrize("use", ["run", "to_pandas"])
    def test_a_run_ends_after_its_duration_also_while_no_unit_answers(self, on_unit, unit, use):
        if use == "to_pandas":
            pytest.importorskip("pandas")
        session = on_unit(["FREQ"], duration=100, method="batch")
        session.on(Sampled, lambda _: unit.turn_key(on=session.progress.samples < 20))
        began = next(session).time
        getattr(session, use)(10)
        assert 10 <= unit.now - began < 15

    def test_of_a_rate_and_a_duration_are_counted_not_waited_for(self, on_unit):
        assert len(list(on_unit(["FREQ"], rate=2, duration=10))) == 21

    def test_are_counted_with_their_rate(self, on_unit):
        session = on_unit(["FREQ"], count=50, method="batch")
        session.run()
        progress = session.progress
        assert (progress.samples, progress.failed_cycles) == (50, 0)
        assert progress.rate == pytest.approx(50 / progress.seconds)
        assert repr(progress).startswith("<RunProgress 50 samples in ")

    def test_come_at_a_rate_at_most(self, on_unit):
        samples = list(on_unit(["FREQ"], rate=2, count=20))
        assert samples[-1].time - samples[0].time >= 0.9 * 19 / 2

    def test_none_are_none(self, on_unit):
        assert list(on_unit(["FREQ"], count=0)) == []

    def test_end_by_stop_and_leave_the_unit_free(self, on_unit, unit):
        session = on_unit(["FREQ"], method="stream")
        for number, _ in enumerate(session):
            if number == 5:
                session.stop()
        assert number < 200
        with unit.connect() as ecu:
            assert ecu.read("TWAT")

    def test_of_a_closed_session_are_an_error(self, on_unit):
        session = on_unit(["FREQ"])
        session.close()
        session.close()
        with pytest.raises(errors.LinkClosed):
            next(session)

    def test_of_a_replay_end_with_it(self, on_unit, tmp_path):
        path = tmp_path / "drive.pcapng"
        assert on_unit(["FREQ"], count=50, record=path, method="batch").run() == 50
        replayed = list(mikas.session(f"replay:{path}?clock=simulated", ["FREQ"], method="batch"))
        assert replayed
        assert replayed[-1].time - replayed[0].time < 10


class TestEvents:
    def test_are_all_and_the_samples_among_them(self, on_unit):
        session = on_unit(["FREQ"], count=10)
        events = list(session.events())
        assert {UnitFound, StateChanged, Sampled} <= {type(event) for event in events}
        assert sum(isinstance(event, Sampled) for event in events) == 10
        assert session.unit is not None
        assert session.method in mikas.client.METHODS

    def test_reach_the_listeners_of_their_class(self, on_unit):
        session, samples, everything = on_unit(["FREQ"], count=10), queue.Queue(), []
        session.on(Sampled, samples.put)
        remove = session.on(Event, everything.append)
        next(session)
        remove()
        before = len(everything)
        assert session.run() == 9
        assert samples.qsize() == 10
        assert len(everything) == before

    def test_a_listener_that_raises_ends_it(self, on_unit):
        session = on_unit(["FREQ"])
        session.on(Sampled, lambda _: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            session.run()

    def test_an_adapter_comes_back_and_the_gap_is_said(self, on_unit, unit):
        gaps = []
        session = on_unit(["FREQ"], method="batch")
        session.on(Gap, gaps.append)
        for _ in range(5):
            next(session)
        unit.unplug()
        for _ in range(5):
            assert next(session).values
        assert [gap.ended is not None for gap in gaps] == [False, True]
        assert gaps[0].began == gaps[1].began

    def test_alarms_follow_their_samples(self, on_unit, unit):
        alarms = []
        session = on_unit(["TWAT"], method="batch")
        session.on(AlarmChanged, alarms.append)
        next(session)
        unit.set("TWAT", 110)
        for _ in range(50):
            next(session)
        assert [alarm.name for alarm in alarms] == ["TWAT"]

    def test_stored_faults_are_read_unless_unwanted(self, on_unit, unit):
        for faults in (True, False):
            with on_unit(["FREQ"], duration=60, rate=2, method="batch", faults=faults) as session:
                session.run()
            assert (b"\x02" in unit.requests) is faults
            unit.forget_requests()

    def test_the_stored_faults_are_events(self, on_unit, unit):
        unit.faults = [13, 53]
        session, readings = on_unit(["FREQ"], duration=60, rate=2, method="batch"), []
        session.on(FaultReading, lambda reading: readings.append(reading.codes))
        session.run()
        assert readings[0] == readings[-1] == (13, 53)


class TestRecording:
    def test_has_the_faults_of_its_end(self, on_unit, unit, tmp_path):
        path = tmp_path / "drive.pcapng"
        session = on_unit(["FREQ"], count=200, method="batch", record=path)
        next(session)
        unit.faults = [13]
        session.run()
        assert mikas.open(path).raw.fault_readings
        assert max(
            reading.codes
            for port in mikas.open(path).raw.fault_readings.values()
            for reading in port
        ) == (13,)

    @pytest.mark.parametrize("is_device", [False, pytest.param(True, marks=pytest.mark.posix)])
    def test_without_an_answer_leaves_no_file_so_that_the_call_works_again(
        self, on_unit, unit, tmp_path, is_device
    ):
        path = tmp_path / "drive.pcapng"
        if is_device:
            os.mkfifo(path)
            reader = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
        unit.turn_key(on=False)
        with pytest.raises(errors.NoConnection):
            on_unit(["FREQ"], record=path).run()
        assert path.exists() is is_device  # nothing is deleted that was there
        if is_device:
            os.close(reader)
            return
        unit.turn_key(on=True)
        assert on_unit(["FREQ"], record=path, count=5).run() == 5

    def test_is_of_the_whole_session_with_its_marks(self, on_unit, tmp_path):
        path = tmp_path / "drive.pcapng"
        with on_unit(["FREQ", "TWAT"], count=30, record=str(path)) as session:
            next(session)
            session.mark("here")
            samples = 1 + session.run()
            assert samples == 30
            assert session.recording.samples >= samples  # until the last reading of the faults
        recording = mikas.open(path)
        assert {channel.name for channel in recording.channels} == {"FREQ", "TWAT"}
        assert "here" in [getattr(event, "label", None) for event in recording.events]

    def test_an_existing_file_is_refused_before_anything_is_opened(self, tmp_path):
        path = tmp_path / "drive.pcapng"
        path.write_bytes(b"mine")
        with pytest.raises(errors.CaptureError):
            mikas.session(SIM, ["FREQ"], record=path)
        assert path.read_bytes() == b"mine"

    def test_a_failure_is_raised_or_called_back(self, on_unit, tmp_path, monkeypatch):
        failure = errors.DiskFull("drive.pcapng", mikas.errors.reason_of(OSError(28, "No space")))
        monkeypatch.setattr(Recorder, "failure", property(lambda self: failure))
        with pytest.raises(errors.DiskFull):
            on_unit(["FREQ"], record=tmp_path / "a.pcapng").run()
        said = []
        session = on_unit(
            ["FREQ"], count=5, record=tmp_path / "b.pcapng", on_record_failure=said.append
        )
        assert session.run() == 5
        assert said == [failure]


class TestWhatIsRefused:
    @pytest.mark.parametrize(
        ("options", "error"),
        [
            ({"channels": ["FREK"]}, errors.UnknownParameter),
            ({"channels": ["FREQ/0"]}, errors.UsageError),
            ({"method": "fastest"}, errors.UsageError),
            ({"rate": -1}, errors.UsageError),
            ({"count": -1}, errors.UsageError),
            ({"duration": float("nan")}, errors.UsageError),
            ({"interpretation": "mine"}, errors.UsageError),
            ({"bogus": 1}, TypeError),
        ],
    )
    def test_before_the_port_is_opened(self, options, error):
        def never(url):
            raise AssertionError

        with pytest.raises(error):
            mikas.session(SIM, open_port=never, **options)

    def test_no_unit_is_raised_unless_patient(self, on_unit, unit):
        unit.turn_key(on=False)
        with pytest.raises(errors.NoConnection):
            next(on_unit(["FREQ"]))
        session = on_unit(["FREQ"], patient=True)
        events = session.events()
        assert isinstance(next(events), StateChanged)
        unit.turn_key(on=True)
        assert next(session).values


def test_jobs_run_between_two_cycles(on_unit):
    session = on_unit(["FREQ"], method="stream")
    next(session)
    future = session.call(lambda ecu: ecu.faults())
    while not future.done():
        next(session)
    assert future.result() == ()


class TestAsync:
    def test_samples_and_jobs(self, unit):
        async def scene():
            samples = []
            async with mikas.async_session(
                SIM, ["FREQ"], open_port=lambda _: unit.link(), method="batch"
            ) as session:
                async for sample in session:
                    samples.append(sample.values["FREQ"])
                    if len(samples) == 10:
                        break
                asked = asyncio.ensure_future(session.call(lambda ecu: ecu.faults()))
                async for _ in session:
                    if asked.done():
                        break
                assert asked.result() == ()
            return samples

        assert len(asyncio.run(scene())) == 10

    def test_a_run_feeds_listeners_a_queue_and_a_recording(self, unit, tmp_path):
        path = tmp_path / "drive.pcapng"

        async def scene():
            taken, loop = asyncio.Queue(), asyncio.get_running_loop()
            async with mikas.async_session(
                SIM, ["FREQ"], open_port=lambda _: unit.link(), method="batch", count=20,
                record=path,
            ) as session:  # fmt: skip
                session.on(Sampled, partial(loop.call_soon_threadsafe, taken.put_nowait))
                first = await anext(session)
                assert session.mark("here") is not None
                assert await session.run() == 19
                assert session.progress.samples == 20
                assert (session.method, session.recording.path) == ("batch", path)
                assert session.unit.version_code == 0x0A
            return first, [taken.get_nowait() for _ in range(taken.qsize())]

        first, taken = asyncio.run(scene())
        assert (taken[0], len(taken)) == (first, 20)
        assert "here" in [getattr(event, "label", None) for event in mikas.open(path).events]

    def test_a_cancelled_run_stops(self, unit):
        async def scene():
            async with mikas.async_session(
                SIM, ["FREQ"], open_port=lambda _: unit.link(), method="batch"
            ) as session:
                running, begun = asyncio.ensure_future(session.run()), asyncio.Event()
                loop = asyncio.get_running_loop()
                session.on(Sampled, lambda _: loop.call_soon_threadsafe(begun.set))
                await begun.wait()
                running.cancel()
                with pytest.raises(asyncio.CancelledError):
                    await running

        asyncio.run(scene())
        with unit.connect() as ecu:
            assert ecu.read("TWAT")

    def test_a_cancelled_wait_loses_no_sample(self, unit):
        async def scene():
            times = []
            async with mikas.async_session(
                SIM, ["FREQ"], open_port=lambda _: unit.link(), method="batch"
            ) as session:
                heard = []
                session.session.on(Sampled, lambda sample: heard.append(sample.time))
                for number in range(20):
                    task = asyncio.ensure_future(anext(session))
                    if number % 2:
                        await asyncio.sleep(0)
                        task.cancel()
                    with suppress(asyncio.CancelledError):
                        times.append((await task).time)
                while len(times) < len(heard):
                    times.append((await anext(session)).time)
                    if len(times) >= 20:
                        break
                return times, heard

        times, heard = asyncio.run(scene())
        assert times == heard[: len(times)]

    def test_an_error_is_raised_where_it_is_awaited(self, unit):
        unit.turn_key(on=False)

        async def scene():
            async with mikas.async_session(
                SIM, ["FREQ"], open_port=lambda _: unit.link()
            ) as session:
                await anext(session)

        with pytest.raises(errors.NoConnection):
            asyncio.run(scene())


def test_a_client_without_a_session_does_not_load_it():
    import subprocess

    code = "import sys, mikas; mikas.connect; print('mikas.live' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_one_channel_may_be_a_text():
    with mikas.session("sim:?clock=simulated", "FREQ", count=1) as session:
        assert next(session).values == {"FREQ": 840}
        with pytest.raises(TypeError, match=r"a class of mikas.sampling.events.*not 'sample'"):
            session.on("sample", print)
