"""How a session ends: closed by another thread, twice, by a task that is cancelled; its jobs."""

from __future__ import annotations

import asyncio
from concurrent.futures import CancelledError, ThreadPoolExecutor

import pytest

import mikas
from mikas import errors
from mikas.sampling.events import Sampled

SIM = "sim:?clock=simulated"


@pytest.mark.parametrize("method", ["batch", "stream", "stroke0"])
def test_another_thread_may_close_it(on_unit, unit, method):
    session = on_unit(["FREQ", "TWAT"], method=method)
    next(session)
    with ThreadPoolExecutor(1) as threads:
        closing = threads.submit(session.close)
        session.run()
        closing.result()
    with unit.connect() as ecu:
        assert ecu.read("TWAT")


def test_closing_ends_a_long_job(on_unit):
    session = on_unit(["FREQ"], method="batch")
    next(session)
    with ThreadPoolExecutor(1) as threads:

        def long(ecu):
            closing.append(threads.submit(session.close))
            while True:
                ecu.read("TWAT")

        closing = []
        job = session.call(long)
        session.run()
        closing[0].result()
        with pytest.raises(CancelledError):
            job.result()


def test_a_job_after_the_end_speaks_of_no_adapter(on_unit):
    session = on_unit(["FREQ"], count=2)
    session.run()
    with pytest.raises(errors.LinkClosed, match=r"is closed\. Start sampling again"):
        session.call(lambda ecu: ecu.faults()).result()


@pytest.mark.parametrize("options", [{"count": 1.5}, {"count": True}, {"duration": "5"}])
def test_a_wrong_length_is_refused(options):
    with pytest.raises(errors.UsageError, match=next(iter(options))):
        mikas.session(SIM, ["FREQ"], **options)


class TestAsync:
    def test_a_cancelled_close_closes_the_port_all_the_same(self, unit):
        async def scene():
            session = mikas.async_session(SIM, ["FREQ"], open_port=lambda _: unit.link())
            await anext(session)
            closing = asyncio.ensure_future(session.close())
            await asyncio.sleep(0)
            closing.cancel()
            with pytest.raises(asyncio.CancelledError):
                await closing
            await session.close()  # waits for the first one
            assert session.session.acquisition.ecu is None

        asyncio.run(scene())

    def test_two_tasks_share_the_samples(self, unit):
        async def scene():
            session = mikas.async_session(SIM, ["FREQ"], open_port=lambda _: unit.link(), count=20)

            async def times():
                return [sample.time async for sample in session]

            both = await asyncio.gather(times(), times())
            await session.close()
            return [*both[0], *both[1]]

        times = asyncio.run(scene())
        assert len(set(times)) == len(times) == 20

    def test_after_a_listeners_error_the_samples_go_on(self, unit):
        async def scene():
            async with mikas.async_session(
                SIM, ["FREQ"], open_port=lambda _: unit.link()
            ) as session:
                remove = session.on(Sampled, lambda _: 1 / 0)
                with pytest.raises(ZeroDivisionError):
                    await anext(session)
                remove()
                assert (await anext(session)).values

        asyncio.run(scene())

    def test_a_cancelled_job_ends_and_sampling_goes_on(self, unit):
        async def scene():
            async with mikas.async_session(
                SIM, ["FREQ"], open_port=lambda _: unit.link(), method="batch"
            ) as session:
                loop, begun, ended = asyncio.get_running_loop(), asyncio.Event(), asyncio.Event()

                def long(ecu):
                    loop.call_soon_threadsafe(begun.set)
                    try:
                        while True:
                            ecu.read("TWAT")
                    finally:
                        loop.call_soon_threadsafe(ended.set)

                await anext(session)
                job = asyncio.ensure_future(session.call(long))
                sampling = asyncio.ensure_future(session.run())
                await begun.wait()
                job.cancel()
                await ended.wait()
                heard = asyncio.Event()
                session.on(Sampled, lambda _: loop.call_soon_threadsafe(heard.set))
                await heard.wait()
                session.stop()
                assert await sampling

        asyncio.run(scene())
