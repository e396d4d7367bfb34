"""What only `AsyncEcu` has to answer for: its names, leaving, cancelling, the loop that goes on."""

from __future__ import annotations

import asyncio
import inspect
import threading

import pytest
from client_harness import bench, by_worker, ecu_on

from mikas import errors
from mikas.client import AsyncEcu, AsyncMemorySpace, Ecu, MemorySpace
from mikas.client.parameters.polling import FIXED_METHODS as METHODS
from mikas.link import open_link
from virtual_harness import DATA

SIM = "sim:?clock=simulated"


def public(of):
    return {name for name in dir(of) if not name.startswith("_")}


def test_every_public_name_of_ecu_is_there():
    made = AsyncEcu(ecu_on(bench()))
    own = {"use_catalog"}  # of who samples, which is no asyncio program's
    assert public(Ecu) - own | {"memory", "catalog"} <= public(made)
    assert public(MemorySpace) <= public(made.memory.ram)
    assert public(made.ecu.memory) - {"NAMES"} <= public(made.memory)
    asyncio.run(made.close())


def test_async_methods_delegate_and_have_the_same_documentation():
    for there, here in ((Ecu, AsyncEcu), (MemorySpace, AsyncMemorySpace)):
        for name in public(there) & public(here) - {
            "close",
            "record",
            "stream",
            "model",
            "version_code",
        }:
            delegated = inspect.getattr_static(here, name, None)
            if delegated is not None:
                assert delegated.__wrapped__ is inspect.getattr_static(there, name)
                assert delegated.__doc__ == getattr(there, name).__doc__


def test_connect_takes_the_same_settings_and_raises_the_same():
    async def scene():
        async with await AsyncEcu.connect(SIM, interpretation="literal", retries=1) as ecu:
            assert ecu.ecu.tester.retries == 1
            assert (await ecu.read("UACC"))["UACC"].interpretation == "literal"
        with pytest.raises(errors.UsageError, match="maybe"):
            await AsyncEcu.connect(SIM, echo="maybe")
        with pytest.raises(errors.EchoOnly):
            await AsyncEcu.connect(SIM + "&scenario=key-off&lost=1", retries=0)

    asyncio.run(scene())


@pytest.mark.parametrize("is_done", [False, True], ids=["meanwhile", "just done"])
def test_a_cancelled_connect_leaves_no_port_open(monkeypatch, is_done):
    opened, begun, go = [], threading.Event(), threading.Event()
    others = set(threading.enumerate())  # a worker of another test may just be ending

    def slow(url):
        opened.append(open_link(url))
        begun.set()
        assert go.wait(30)
        return opened[0]

    monkeypatch.setattr("mikas.client.connecting.open_link", slow)

    async def scene():
        connecting = asyncio.create_task(AsyncEcu.connect(SIM))
        while not begun.is_set():
            assert not connecting.done(), connecting
            await asyncio.sleep(0)
        new = set(threading.enumerate()) - others
        worker = next(it for it in new if it.name.startswith("mikas"))
        if is_done:
            go.set()
            worker.join(0.05)  # the loop does not run meanwhile
        connecting.cancel()
        with pytest.raises(asyncio.CancelledError):
            await connecting
        go.set()
        worker.join(30)

    asyncio.run(scene())
    with pytest.raises(errors.LinkLost):
        opened[0].write(b"\x01")


@pytest.mark.parametrize("method", METHODS)
class TestLeavingAWatch:
    def scene(self, method, act):
        it = bench()

        async def play():
            async with by_worker(it) as ecu:
                await act(ecu, method)
                assert (await ecu.read("TWAT"))["TWAT"].raw == DATA[0x1A]
                if method == "stream" or method.startswith("stroke"):
                    assert any(h.kind == "stream-end" for h in it.happenings)

        asyncio.run(play())

    def test_a_break_leaves_the_unit_free(self, method):
        async def act(ecu, method):
            async for _ in ecu.watch("TWAT", method=method):
                break

        self.scene(method, act)

    def test_an_error_leaves_the_unit_free(self, method):
        async def act(ecu, method):
            try:
                async for _ in ecu.watch("TWAT", method=method):
                    raise ZeroDivisionError
            except ZeroDivisionError:
                await ecu.read("FREQ")

        self.scene(method, act)

    def test_cancelling_leaves_the_unit_free(self, method):
        async def act(ecu, method):
            observed = asyncio.Event()

            async def watch():
                async for _ in ecu.watch("TWAT", method=method):
                    observed.set()

            task = asyncio.create_task(watch())
            await observed.wait()
            task.cancel()
            with pytest.raises(asyncio.CancelledError):
                await task

        self.scene(method, act)

    def test_cancelling_before_the_first_sample_leaves_the_unit_free(self, method):
        async def act(ecu, method):
            async def watch():
                async for _ in ecu.watch("TWAT", method=method):
                    pass

            task = asyncio.create_task(watch())
            await asyncio.sleep(0)
            task.cancel()
            try:
                await task
            except asyncio.CancelledError:
                await ecu.read("FREQ")  # free at once, though the error still holds its frames

        self.scene(method, act)

    def test_aclose_ends_the_samples_for_good(self, method):
        async def act(ecu, method):
            samples = ecu.watch("TWAT", method=method)
            await anext(samples)
            await samples.aclose()
            await samples.aclose()
            assert [s async for s in samples] == []

        self.scene(method, act)

    def test_a_count_leaves_the_unit_free(self, method):
        async def act(ecu, method):
            samples = ecu.watch("TWAT", method=method, count=1)
            await anext(samples)

        self.scene(method, act)


def test_cancelling_in_a_stream_frees_the_unit():
    async def play():
        async with by_worker(bench()) as ecu:
            for turns in range(6):  # as the worker is still beginning it, and later

                async def stream():
                    async with ecu.stream("TWAT") as readings:
                        async for _ in readings:
                            pass

                task = asyncio.create_task(stream())
                for _ in range(turns):
                    await asyncio.sleep(0)
                task.cancel()
                with pytest.raises(asyncio.CancelledError):
                    await task
                assert await ecu.read("TWAT")

    asyncio.run(play())


def test_an_error_in_a_stream_comes_out_as_it_is():
    it = bench()

    async def play():
        async with by_worker(it) as ecu:

            async def stream(act):
                async with ecu.stream("TWAT") as readings:
                    await anext(readings)
                    act()
                    async for _ in readings:
                        pass

            with pytest.raises(ZeroDivisionError):
                await stream(lambda: 1 / 0)
            assert await ecu.read("TWAT")
            with pytest.raises(errors.LinkLost):
                await stream(it.link.unplug)

    asyncio.run(play())


def test_the_loop_goes_on_during_a_request():
    it = bench()

    async def play():
        async with by_worker(it) as ecu:
            many = await asyncio.gather(*(ecu.read("TWAT") for _ in range(20)))
            assert all(r["TWAT"].raw == DATA[0x1A] for r in many)
            statistics = await ecu.run(lambda: ecu.ecu.tester.statistics)
            assert statistics.requests == 20

    asyncio.run(play())


def test_connecting_may_be_entered_at_once():
    async def main():
        async with AsyncEcu.connect(SIM) as ecu:
            assert (await ecu.read("TWAT"))["TWAT"].value == 86
        with pytest.raises(errors.LinkClosed):
            await ecu.read("TWAT")
        with pytest.raises(errors.UsageError):
            async with AsyncEcu.connect(SIM, echo="maybe"):
                pytest.fail("it is not entered")

    asyncio.run(main())
