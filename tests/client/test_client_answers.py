"""The gate takes True or False and nothing else, and shows a person what is going to change."""

from __future__ import annotations

import asyncio
from functools import partial

import numpy as np
import pytest
from client_harness import bench, ecu_on
from test_client_gate import CHANGES, changing

import mikas
from mikas.client import AsyncEcu, Change
from mikas.commands import Safety
from mikas.errors import DeadlinePassed, NotConfirmed
from virtual_harness import DATA

SIM = "sim:?clock=simulated"


async def never(change):
    raise AssertionError("it has to be awaited first")


@pytest.mark.parametrize("name", CHANGES)
@pytest.mark.parametrize("answer", ["no", "yes", "", 0, 1, None, [], np.True_], ids=repr)
def test_anything_but_a_bool_changes_nothing(name, answer, tmp_path):
    it = bench()
    ecu = ecu_on(it, confirm=lambda _: answer, journal=tmp_path / "journal")
    with pytest.raises(TypeError, match="True or False"):
        CHANGES[name](ecu)
    assert changing(it) == []
    assert not (tmp_path / "journal").exists()


@pytest.mark.parametrize("name", CHANGES)
def test_a_coroutine_does_not_pass_for_yes(name):
    it = bench()
    with pytest.raises(TypeError, match="AsyncEcu"):
        CHANGES[name](ecu_on(it, confirm=never))
    with pytest.raises(TypeError, match="AsyncEcu"):
        CHANGES[name](ecu_on(it, confirm=partial(never)))
    assert changing(it) == []


def test_connect_refuses_an_async_function_before_the_port_is_opened():
    with pytest.raises(TypeError, match="AsyncEcu"):
        mikas.connect("/dev/no-such-port", confirm=never)


@pytest.mark.parametrize("confirm", [True, 1, "yes"])
def test_connect_refuses_what_is_no_function(confirm):
    with pytest.raises(TypeError, match="confirm is a function"):
        mikas.connect(SIM, confirm=confirm)
    with pytest.raises(TypeError, match="confirm is a function"):
        asyncio.run(AsyncEcu.connect(SIM, confirm=confirm))


def changed(confirm):
    """Return whether a write to CODE passed, and the gate's questions; by a real `connect`."""

    async def scene():
        async with await AsyncEcu.connect(SIM, confirm=confirm) as ecu:
            before = await ecu.memory.code.read(0x8000)
            try:
                await ecu.memory.code.write(0x8000, before ^ 0xFF)
            except NotConfirmed:
                return False
            assert await ecu.memory.code.read(0x8000) == before ^ 0xFF
            return True

    return asyncio.run(scene())


class TestAnAsyncConfirm:
    @pytest.mark.parametrize("answer", [True, False])
    def test_is_awaited_in_the_event_loop(self, answer):
        asked = []

        async def confirm(change: Change):
            await asyncio.sleep(0)
            asked.append((asyncio.get_running_loop(), change))
            return answer

        assert changed(confirm) is answer
        ((_, change),) = asked
        assert (change.name, change.address, change.safety) == ("code", 0x8000, Safety.DANGEROUS)

    def test_a_plain_function_serves_as_well(self):
        assert changed(lambda _: True)
        assert not changed(lambda _: False)

    def test_its_error_is_raised_and_nothing_sent(self):
        async def confirm(_):
            raise ZeroDivisionError

        with pytest.raises(ZeroDivisionError):
            changed(confirm)

    def test_anything_but_a_bool_is_refused(self):
        async def confirm(_):
            return "yes"

        with pytest.raises(TypeError, match="'yes'"):
            changed(confirm)

    def test_a_dialog_that_is_cancelled_is_a_no(self):
        async def confirm(_):
            raise asyncio.CancelledError

        async def scene():
            async with AsyncEcu.connect(SIM, confirm=confirm) as ecu:
                with pytest.raises(NotConfirmed, match="question was cancelled"):
                    await ecu.memory.code.write(0x8000, 1)

        asyncio.run(scene())

    def test_the_timeout_of_a_call_ends_an_open_question(self):
        async def scene():
            ended = asyncio.Event()

            async def confirm(_):
                link = ecu.ecu.tester.link
                link.gather(link.now() + 60)  # the person thinks for a minute
                try:
                    await asyncio.Event().wait()
                finally:
                    ended.set()

            async with AsyncEcu.connect(SIM, confirm=confirm) as ecu:
                before = await ecu.memory.code.read(0x8000)
                with pytest.raises(DeadlinePassed):
                    await ecu.memory.code.write(0x8000, before ^ 0xFF, timeout=30)
                await ended.wait()
                assert await ecu.memory.code.read(0x8000) == before

        asyncio.run(scene())

    def test_closing_answers_an_open_question_with_no(self):
        async def scene():
            asked, ended = asyncio.Event(), asyncio.Event()

            async def confirm(_):
                asked.set()
                try:
                    await asyncio.Event().wait()
                finally:
                    ended.set()

            ecu = await AsyncEcu.connect(SIM, confirm=confirm)
            writing = asyncio.ensure_future(ecu.memory.code.write(0x8000, 1))
            await asked.wait()
            await ecu.close()
            with pytest.raises(NotConfirmed, match="closed before"):
                await writing
            await ended.wait()

        asyncio.run(scene())

    def test_cancelling_the_change_ends_the_question(self):
        async def scene():
            asked, ended = asyncio.Event(), asyncio.Event()

            async def confirm(_):
                asked.set()
                try:
                    await asyncio.Event().wait()
                finally:
                    ended.set()

            async with await AsyncEcu.connect(SIM, confirm=confirm) as ecu:
                before = await ecu.memory.code.read(0x8000)
                writing = asyncio.ensure_future(ecu.memory.code.write(0x8000, before ^ 1))
                await asked.wait()
                writing.cancel()
                with pytest.raises(asyncio.CancelledError):
                    await writing
                await ended.wait()
                assert await ecu.memory.code.read(0x8000) == before

        asyncio.run(scene())


class TestWhatThePersonIsShown:
    def asked(self, change, **settings):
        seen = []
        ecu = ecu_on(bench(**settings), confirm=lambda it: seen.append(it) or False)
        with pytest.raises(NotConfirmed):
            change(ecu)
        (only,) = seen
        return only

    def test_a_parameter_has_its_values_in_units(self):
        change = self.asked(lambda ecu: ecu.write_parameter("UOZ", 12.5))
        raw = ecu_on(bench()).read("UOZ")["UOZ"]
        assert change.name == "UOZ"
        assert change.address is None
        assert (change.old, change.new.en) == (raw.shown, f"12.5 {raw.unit}")
        assert change.new.ru.startswith("12,5 ")

    def test_a_parameter_that_cannot_be_read_has_no_old_value(self):
        code = next(iter(set(range(256)) - set(DATA)))
        change = self.asked(lambda ecu: ecu.write_parameter(f"0x{code:02X}", raw=b"\x01"))
        assert change.old is None
        assert change.new is not None

    def test_bytes_have_space_and_address(self):
        change = self.asked(lambda ecu: ecu.memory.xram.write_block(0x1234, b"\x0d\x40"))
        assert (change.name, change.address) == ("xram", 0x1234)
        assert change.new == ("0D 40", "0D 40")
        assert change.old.en == change.before

    def test_erased_faults_are_named(self):
        change = self.asked(lambda ecu: ecu.erase_faults())
        assert len(change.old.en) > 20
        assert change.new == ("no faults", "ошибок нет")

    def test_a_list_names_its_parameters(self):
        assert self.asked(lambda ecu: ecu.set_list("TWAT", "FREQ")).new.en == "TWAT, FREQ"

    def test_a_jump_has_its_address(self):
        assert self.asked(lambda ecu: ecu.goto(0x8000)).address == 0x8000
