"""A session's end: closed twice or before it began, a recording whose last bytes find no room."""

from __future__ import annotations

import asyncio

import pytest

import mikas
from mikas import errors
from mikas.errors import system_error
from mikas.sampling.events import Sampled
from mikas.testing.units import VirtualUnit

SIM = "sim:?clock=simulated"


def full_disk(file, data):
    raise system_error(28)


@pytest.fixture
def disk_that_fills(monkeypatch):
    def fill(*_):
        monkeypatch.setattr("mikas.recording.capture.writer.write_all", full_disk)

    return fill


class TestARecordingThatCannotEnd:
    def test_of_a_session_is_raised(self, tmp_path, disk_that_fills):
        session = mikas.session(SIM, ["FREQ"], count=5, record=tmp_path / "a.pcapng")
        assert next(session)
        disk_that_fills()
        session.mark("the last note")
        with pytest.raises(errors.DiskFull):
            session.close()
        session.close()
        assert isinstance(session.recording.failure, errors.DiskFull)

    def test_of_a_session_is_handed_over_once(self, tmp_path, disk_that_fills):
        failures = []
        with mikas.session(
            SIM, ["FREQ"], count=5, record=tmp_path / "a.pcapng", on_record_failure=failures.append
        ) as session:
            assert next(session)
            disk_that_fills()
            session.mark("the last note")
        assert [type(each) for each in failures] == [errors.DiskFull]

    def test_of_a_unit_is_raised_or_handed_over_once(self, tmp_path, disk_that_fills, monkeypatch):
        failures = []
        with VirtualUnit() as unit, unit.connect() as ecu:
            recording = ecu.record(tmp_path / "a.pcapng")
            disk_that_fills()
            recording.mark("the last note")
            with pytest.raises(errors.DiskFull):
                recording.close()
            recording.close()
            monkeypatch.undo()
            with ecu.record(tmp_path / "b.pcapng", on_failure=failures.append) as recording:
                ecu.read("TWAT")
                disk_that_fills()
                recording.mark("the last note")
        assert [type(each) for each in failures] == [errors.DiskFull]

    def test_of_a_unit_is_not_raised_again_by_the_end(self, tmp_path, disk_that_fills):
        with VirtualUnit() as unit, unit.connect() as ecu:
            recording = ecu.record(tmp_path / "a.pcapng")
            ecu.read("TWAT")
            disk_that_fills()
            with pytest.raises(errors.DiskFull):
                ecu.read("TWAT")
            recording.close()


def test_a_session_that_never_ran_leaves_no_file(tmp_path):
    """A mistake before the loop, and the same program must work again."""
    for _ in range(2):
        session = mikas.session(SIM, ["FREQ"], record=tmp_path / "a.pcapng")
        with pytest.raises(TypeError), session:
            session.on("sample", print)
        assert list(tmp_path.iterdir()) == []


class TestAJobOfAClosedSession:
    def test_that_never_ran_fails(self):
        session = mikas.session(SIM, ["FREQ"])
        before = session.call(lambda ecu: ecu.faults())
        session.close()
        after = session.call(lambda ecu: ecu.faults())
        for future in (before, after):
            with pytest.raises(errors.LinkClosed, match="is closed"):
                future.result(timeout=0)

    def test_after_a_failed_run_fails_with_its_error(self):
        def absent(url):
            raise errors.PortNotFound(url=url, found="none")

        session = mikas.session(SIM, ["FREQ"], open_port=absent)
        with pytest.raises(errors.PortNotFound):
            next(session)
        session.close()
        with pytest.raises(errors.PortNotFound):
            session.call(lambda ecu: ecu.faults()).result(timeout=0)


class TestAnAsyncSession:
    def test_may_be_closed_twice(self):
        async def scene():
            async with mikas.async_session(SIM, ["FREQ"]) as session:
                assert await anext(session)
                await session.close()
            await session.close()

        asyncio.run(scene())

    def test_that_is_closed_says_so(self):
        async def scene():
            session = mikas.async_session(SIM, ["FREQ"])
            await session.close()
            for use in (lambda: anext(session), session.run, session.to_pandas):
                with pytest.raises(errors.LinkClosed):
                    await use()
            with pytest.raises(errors.LinkLost):
                await session.call(lambda ecu: ecu.faults())

        asyncio.run(scene())

    def test_that_has_failed_can_be_iterated_again(self):
        """The error is not kept for the next one that waits."""
        raised = []

        def once(sample):
            if not raised:
                raised.append(sample)
                raise KeyError("mine")

        async def scene():
            async with mikas.async_session(SIM, ["FREQ"], count=3) as session:
                session.on(Sampled, once)
                with pytest.raises(KeyError):
                    await anext(session)
                return [sample async for sample in session]

        assert len(asyncio.run(scene())) == 2


class TestWrongArguments:
    def test_a_link_is_not_an_address(self):
        with VirtualUnit() as unit, pytest.raises(TypeError, match="open_port"):
            mikas.session(unit.link(), ["FREQ"])

    def test_a_listener_is_a_function(self):
        with mikas.session(SIM, ["FREQ"]) as session, pytest.raises(TypeError, match="None"):
            session.on(Sampled, None)

    @pytest.mark.parametrize("wrong", [{"count": 2.5}, {"duration": "5"}, {"duration": -1}])
    def test_a_length_is_a_number(self, wrong):
        with pytest.raises(errors.UsageError, match=next(iter(wrong))):
            mikas.session(SIM, ["FREQ"], **wrong)

    def test_an_empty_address_is_none_of_the_settings(self, monkeypatch):
        monkeypatch.setenv("MIKAS_PORT", SIM)
        with pytest.raises(errors.BadPortUrl, match="empty"):
            mikas.session("", ["FREQ"]).run()


def test_a_port_of_ones_own_needs_no_address(monkeypatch):
    monkeypatch.delenv("MIKAS_PORT", raising=False)
    with (
        VirtualUnit() as unit,
        mikas.session(
            channels=["FREQ"], count=3, open_port=lambda _: unit.link(), faults=False
        ) as session,
    ):
        assert session.run() == 3
