"""One suite over both clients: what `Ecu` does, `AsyncEcu` does, with equal results and errors."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager

import pytest
from client_harness import bench, by_worker, ecu_on

from mikas import errors
from mikas.client.parameters.polling import FIXED_METHODS as METHODS
from mikas.virtual.memory import pattern
from virtual_harness import DATA, FAULTS


class Direct:
    """An `Ecu` under the names of an `AsyncEcu`, so that one test serves both."""

    def __init__(self, ecu):
        self._there = ecu

    def __getattr__(self, name):
        return asked(getattr(self._there, name))


class Spaces:
    def __init__(self, memory):
        self._memory = memory

    def __getitem__(self, name):
        return Direct(self._memory[name])


def asked(it):
    if hasattr(it, "ram"):
        return Spaces(it)
    if not callable(it):
        return it

    def call(*args, **kwargs):
        made = it(*args, **kwargs)
        if hasattr(made, "__next__"):
            return each(made)
        if hasattr(made, "__enter__"):
            return entered(made)
        return given(made)

    return call


async def given(value):
    return value


async def each(iterator):
    try:
        for item in iterator:
            yield item
    finally:
        iterator.close()


@asynccontextmanager
async def entered(context):
    with context as iterator:
        yield each(iterator)


@asynccontextmanager
async def direct(it, **settings):
    ecu = ecu_on(it, **settings)
    yield Direct(ecu)
    ecu.close()


@pytest.fixture(params=[direct, by_worker], ids=["Ecu", "AsyncEcu"])
def client(request):
    return request.param


def run(test):
    """`test` is a coroutine function: run it in a loop of its own."""

    def runner(client):
        asyncio.run(test(client))

    runner.__doc__ = test.__doc__
    return runner


@run
async def test_info_has_model_and_passport(client):
    async with client(bench()) as ecu:
        info = await ecu.info()
        assert info.version_code == ecu.version_code == 0x0A
        assert info.model == ecu.model
        assert await ecu.passport() == info.passport
        assert ecu.catalog.parameters
        assert {s.known async for s in ecu.supported()} == {True, None}


@run
async def test_all_parameters_or_the_named_ones_are_read(client):
    async with client(bench()) as ecu:
        readings = await ecu.read()
        assert {r.parameter.code: r.raw for r in readings.values()} == DATA
        assert list(await ecu.read("FREQ", "TWAT")) == ["FREQ", "TWAT"]
        assert [f.code for f in await ecu.faults()] == FAULTS


@run
async def test_every_method_gives_the_watched_parameters(client):
    async with client(bench()) as ecu:
        for method in METHODS:
            got = [s async for s in ecu.watch("TWAT", "INJ", method=method, count=3)]
            assert [list(s.readings) for s in got] == [["TWAT", "INJ"]] * 3
        assert await ecu.read("TWAT")


@run
async def test_streams_give_all_parameters_and_leave_the_unit_free(client):
    for stroke in (None, 0, 4):
        async with client(bench()) as ecu:
            observed = 0
            async with ecu.stream("TWAT", "INJ", stroke=stroke) as readings:
                async for each_of in readings:
                    assert each_of["INJ"].raw == DATA[0x3F]
                    observed += 1
                    if observed == 3:
                        break
            assert await ecu.read("TWAT")


@run
async def test_a_list_is_set_and_read(client):
    async with client(bench()) as ecu:
        assert await ecu.set_list("TWAT", "INJ") == ("TWAT", "INJ")
        assert (await ecu.read_list())["INJ"].raw == DATA[0x3F]


@run
async def test_changes_are_asked_for_made_and_read_back(client):
    asked_for = []
    async with client(bench(), confirm=lambda c: asked_for.append(c) or True) as ecu:
        assert (await ecu.write_parameter("SSM", 30)).after.value == 30
        assert (await ecu.write_parameter("SSM", raw=b"\x1f")).after.value == 31
        assert (await ecu.erase_faults()).after == ()
        assert await ecu.goto(0x8000) == b""
        assert await ecu.raw(b"\x01") == b"\x0a"
        assert len(asked_for) == 4


@run
async def test_every_memory_is_read_and_written(client):
    async with client(bench(), confirm=lambda _: True) as ecu:
        for space in ("ram", "xram", "code", "sfr"):
            memory = ecu.memory[space]
            assert memory.name == space
            assert await memory.read(0x40) == pattern(space)[0x40]
            assert await memory.read_block(3, 20) == pattern(space)[3:23]
            parts = [part async for part in memory.blocks(0, memory.last - 40, largest=250)]
            assert b"".join(parts) == pattern(space)[: memory.last - 40]
            break_at = memory.last - 1
            assert (await memory.write(break_at, 7)).after == b"\x07"
            assert (await memory.write_block(0, b"abc")).after == b"abc"


@run
async def test_memory_is_read_and_written_in_the_form_that_the_unit_has(client):
    for missing in ("bytes", "blocks"):
        for unknown in ("silent", "01"):
            it = bench(missing=missing, unknown=unknown)
            async with client(it, confirm=lambda _: True) as ecu:
                for space in ("ram", "xram", "code"):
                    memory = ecu.memory[space]
                    assert (await memory.write(0x40, 7)).after == b"\x07"
                    assert (await memory.write_block(0x41, b"abc")).after == b"abc"
                    assert await memory.read_block(0x40, 4) == b"\x07abc"
                    assert await memory.read(0x43) == ord("c")
                assert (await ecu.memory["sfr"].write(0x90, 7)).after == b"\x07"


@run
async def test_both_clients_raise_the_same_errors(client):
    async with client(bench(missing="stream,sfr")) as ecu:
        for error, call in (
            (errors.UnknownParameter, lambda: ecu.read("TWATT")),
            (errors.NotSupported, lambda: ecu.read("0xEE")),
            (errors.ValueDoesNotFit, lambda: ecu.write_parameter("SSM", 256)),
            (errors.UsageError, ecu.read_list),
            (errors.AddressOutOfRange, lambda: ecu.memory["ram"].read(256)),
            (errors.NotSupported, lambda: ecu.memory["sfr"].read(0)),
            (errors.NotConfirmed, lambda: ecu.memory["code"].write(0, 0)),
            (errors.NotConfirmed, lambda: ecu.goto(0)),
            (errors.UsageError, lambda: ecu.raw(b"")),
        ):
            with pytest.raises(error):
                await call()
        for error, watch in (
            (errors.NotSupported, lambda: ecu.watch("TWAT", method="stream")),
            (errors.UnknownParameter, lambda: ecu.watch("TWATT")),
            (errors.UsageError, lambda: ecu.watch("TWAT", rate=0)),
        ):
            with pytest.raises(error):
                [s async for s in watch()]
        with pytest.raises(errors.UsageError):
            ecu.memory["flash"]


@run
async def test_a_lost_adapter_ends_a_watch_with_an_error(client):
    it = bench()
    async with client(it) as ecu:
        samples = ecu.watch("TWAT")
        await anext(samples)
        it.link.unplug()
        with pytest.raises(errors.LinkLost):
            [s async for s in samples]


@run
async def test_closing_twice_is_closing_once(client):
    async with client(bench()) as ecu:
        await ecu.close()
        await ecu.close()
        with pytest.raises(errors.LinkLost):
            await ecu.read("TWAT")
