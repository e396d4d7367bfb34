"""The one gate that every change of a unit goes through (rule 7 of the house): each is asked
for and journalled, one at a time, also with several threads.
"""

from __future__ import annotations

import threading

import pytest
from client_harness import bench, ecu_on, lines

from mikas.client import Change, Ecu, connect
from mikas.commands import COMMANDS_BY_CODE, Safety
from mikas.errors import (
    JournalError,
    LinkLost,
    NotConfirmed,
    UsageError,
    WriteRefused,
)
from virtual_harness import DATA, FAULTS

CHANGING = {0x12, 0x14, 0x16, 0x22, 0x24, 0x26, 0x32, 0x41, 0x62, 0x64}

# Every change that the public object can make, by name.
CHANGES = {
    "erase": lambda ecu: ecu.erase_faults(),
    "parameter": lambda ecu: ecu.write_parameter("SSM", 30),
    "list": lambda ecu: ecu.set_list("TWAT"),
    "ram": lambda ecu: ecu.memory.ram.write(0x40, 1),
    "ram block": lambda ecu: ecu.memory.ram.write_block(0x40, b"abc"),
    "xram": lambda ecu: ecu.memory.xram.write(0x1234, 1),
    "xram block": lambda ecu: ecu.memory.xram.write_block(0x1234, b"abc"),
    "code": lambda ecu: ecu.memory.code.write(0x1234, 1),
    "code block": lambda ecu: ecu.memory.code.write_block(0x1234, b"abc"),
    "sfr": lambda ecu: ecu.memory.sfr.write(0x90, 1),
    "goto": lambda ecu: ecu.goto(0x8000),
    "raw write": lambda ecu: ecu.raw(b"\x62\x5b\x1e"),
    "raw goto": lambda ecu: ecu.raw(b"\x41\x00\x80"),
    "raw code": lambda ecu: ecu.raw(b"\x16\x00\x80\x01"),
    "raw unknown": lambda ecu: ecu.raw(b"\x99"),
}
WORDS = {
    "erase": "erase_faults", "parameter": "write_parameter", "list": "set_list", "ram": "RAM",
    "xram": "XRAM", "code": "CODE", "sfr": "SFR", "goto": "goto", "raw": "`raw` bodies",
}  # fmt: skip
"""How the documentation of `Ecu` names them, by the first word of their names."""
DANGEROUS = {"code", "code block", "goto", "raw goto", "raw code"}


def changing(it):
    known = {code for code, command in COMMANDS_BY_CODE.items() if command.SAFETY > Safety.READ}
    assert known == CHANGING
    return [body for body in it.requests() if body[0] in CHANGING | {0x99}]


@pytest.mark.parametrize("name", CHANGES)
class TestTheGate:
    def test_no_means_that_nothing_is_changed(self, name, tmp_path):
        asked: list[Change] = []

        def no(change):
            asked.append(change)
            return False

        it = bench()
        ecu = ecu_on(it, confirm=no, journal=tmp_path / "journal")
        with pytest.raises(NotConfirmed) as caught:
            CHANGES[name](ecu)
        assert changing(it) == []
        assert len(asked) == 1
        assert asked[0].what.en in caught.value.text.en
        assert asked[0].what.ru in caught.value.text.ru
        assert not (tmp_path / "journal").exists()
        assert ecu.read("TWAT")

    def test_without_a_confirmation_only_dangerous_changes_stop(self, name):
        it = bench()
        ecu = ecu_on(it)
        if name in DANGEROUS:
            with pytest.raises(NotConfirmed, match="confirm"):
                CHANGES[name](ecu)
            assert changing(it) == []
            assert it.requests() == []  # not even what is there was read first
        else:
            CHANGES[name](ecu)
            assert changing(it) != []

    def test_what_passes_without_a_confirmation_is_said_by_the_unit_and_connect(self, name):
        made, refused = Ecu.__doc__.split("Refused without it")
        assert WORDS[name.split()[0]] in (refused if name in DANGEROUS else made)
        assert "writes to CODE and `goto` (41), which are refused" in connect.__doc__

    def test_yes_is_journalled_before_and_after(self, name, tmp_path):
        observed = []
        it = bench()
        ecu = ecu_on(it, confirm=lambda c: observed.append(c) or True, journal=tmp_path / "journal")
        CHANGES[name](ecu)
        started, done = lines(tmp_path / "journal")
        assert (started["state"], done["state"]) == ("started", "done")
        assert started["outcome"] is None
        for entry in (started, done):
            assert entry["change"] == observed[0].what.en
            assert entry["safety"] == observed[0].safety.name.lower()
            assert entry["command"] == observed[0].command
            assert (entry["before"], entry["after"]) == (observed[0].before, observed[0].after)
            assert entry["port"] == it.link.url
            assert "7.1" in entry["model"]
        assert started["time"] < done["time"]
        assert (observed[0].safety is Safety.DANGEROUS) == (name in DANGEROUS)

    def test_a_journal_that_cannot_be_written_stops_it(self, name, tmp_path):
        (tmp_path / "file").write_text("")
        it = bench()
        ecu = ecu_on(it, confirm=lambda _: True, journal=tmp_path / "file" / "journal")
        with pytest.raises(JournalError, match="journal") as caught:
            CHANGES[name](ecu)
        assert changing(it) == []
        assert isinstance(caught.value, ValueError)

    def test_an_interrupted_one_stands_in_the_journal(self, name, tmp_path, monkeypatch):
        it = bench()
        ecu = ecu_on(it, confirm=lambda _: True, journal=tmp_path / "journal")
        write = it.link.write

        def stop(data):
            if data and data[0] in CHANGING | {0x99}:
                raise KeyboardInterrupt
            write(data)

        it.link.write = stop
        with pytest.raises(KeyboardInterrupt):
            CHANGES[name](ecu)
        assert [e["state"] for e in lines(tmp_path / "journal")] == ["started", "interrupted"]

    def test_a_pulled_plug_stands_in_the_journal(self, name, tmp_path):
        it = bench()

        def pull(change):
            it.link.unplug()
            return True

        ecu = ecu_on(it, confirm=pull, journal=tmp_path / "journal")
        with pytest.raises(LinkLost):
            CHANGES[name](ecu)
        started, failed = lines(tmp_path / "journal")
        assert (started["state"], failed["state"]) == ("started", "failed")
        assert "gone" in failed["outcome"]

    def test_in_a_stream_it_is_refused_and_the_stream_goes_on(self, name):
        it = bench()
        ecu = ecu_on(it, confirm=lambda _: True)
        samples = ecu.watch("TWAT", method="stream")
        next(samples)
        with pytest.raises(UsageError, match="stream"):
            CHANGES[name](ecu)
        assert changing(it) == []
        assert next(samples).readings
        samples.close()


class TestTheJournal:
    def test_the_journal_is_appended_to(self, tmp_path):
        journal = tmp_path / "deep" / "er" / "journal.jsonl"
        for _ in range(2):
            ecu_on(bench(), journal=journal).write_parameter("SSM", 30)
        assert [e["state"] for e in lines(journal)] == ["started", "done"] * 2

    def test_the_journal_keeps_all_bytes_that_were_there(self, tmp_path):
        it = bench()
        ecu = ecu_on(it, journal=tmp_path / "journal")
        before = ecu.memory.xram.read_block(0, 600)
        ecu.memory.xram.write_block(0, bytes(600))
        started, done = lines(tmp_path / "journal")
        assert bytes.fromhex(started["before"]) == before
        assert bytes.fromhex(done["outcome"]) == bytes(600)

    def test_a_refused_change_is_an_error_with_its_reason(self, tmp_path):
        it = bench(missing="write", unknown="01")
        ecu = ecu_on(it, journal=tmp_path / "journal")
        with pytest.raises(WriteRefused):
            ecu.write_parameter("SSM", 30)
        _, failed = lines(tmp_path / "journal")
        assert failed["state"] == "failed"
        assert "refused" in failed["outcome"]

    def test_a_port_with_an_odd_name_can_be_written_down(self, tmp_path):
        it = bench()
        ecu = ecu_on(it, journal=tmp_path / "journal")
        it.link.url = "/dev/tty\udc80Ж\n"
        ecu.write_parameter("SSM", 30)
        assert lines(tmp_path / "journal")[0]["port"] == "/dev/tty\udc80Ж\n"

    def test_a_full_disk_after_the_change_says_that_it_was_made(self, tmp_path):
        it = bench()
        journal = tmp_path / "journal"
        ecu = ecu_on(it, journal=journal)
        write = it.link.write

        def fill(data):
            if data and data[0] == 0x62:
                journal.unlink()
                journal.mkdir()
            write(data)

        it.link.write = fill
        with pytest.raises(JournalError, match="was made") as caught:
            ecu.write_parameter("SSM", 30)
        assert "сделано" in caught.value.text.ru
        assert ecu.read("SSM")["SSM"].value == 30

    def test_a_full_disk_does_not_hide_what_went_wrong(self, tmp_path, said):
        it = bench()
        journal = tmp_path / "journal"
        ecu = ecu_on(it, journal=journal)

        def fail(data):
            if data and data[0] == 0x62:
                journal.unlink()
                journal.mkdir()
                it.link.unplug()
            type(it.link).write(it.link, data)

        it.link.write = fail
        with pytest.raises(LinkLost):
            ecu.write_parameter("SSM", 30)
        (sentence,) = said
        assert sentence.en.startswith(f"The journal {journal} can't be written (")
        assert "но нет того, чем оно закончилось" in sentence.ru

    def test_no_journal_at_all_is_possible(self):
        assert ecu_on(bench()).write_parameter("SSM", 30).after.value == 30


class TestThreads:
    def test_two_threads_read_and_write_through_one_ecu(self, tmp_path):
        it = bench()
        ecu = ecu_on(it, journal=tmp_path / "journal")
        failures = []

        def run(name, values):
            try:
                for value in values:
                    written = ecu.write_parameter(name, value)
                    assert written.after.value == value
                    assert ecu.read("TWAT", "INJ")["INJ"].raw == DATA[0x3F]
            except BaseException as error:
                failures.append(error)
                raise

        threads = [
            threading.Thread(target=run, args=("SSM", range(40))),
            threading.Thread(target=run, args=("FSM", range(100, 140))),
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(30)
        assert failures == []
        assert len(lines(tmp_path / "journal")) == 4 * 40

    def test_lists_of_two_threads_do_not_mix(self):
        ecu = ecu_on(bench())
        failures = []

        def run(name, code):
            try:
                for sample in ecu.watch(name, method="list", count=60):
                    assert sample.readings[name].raw == DATA[code]
            except BaseException as error:
                failures.append(error)
                raise

        threads = [
            threading.Thread(target=run, args=("INJ", 0x3F)),
            threading.Thread(target=run, args=("JAIR", 0x21)),
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(30)
        assert failures == []

    def test_a_request_waits_for_another_threads_stream(self):
        ecu = ecu_on(bench())
        samples = ecu.watch("TWAT", method="stream")
        next(samples)
        got = []
        other = threading.Thread(target=lambda: got.append(ecu.read("TWAT")))
        other.start()
        next(samples)
        assert got == []
        samples.close()
        other.join(30)
        assert got[0]["TWAT"].raw == DATA[0x1A]

    def test_faults_are_erased_though_another_thread_reads_all_the_time(self):
        it = bench()
        ecu = ecu_on(it)
        stop = threading.Event()

        def read():
            while not stop.is_set():
                ecu.read("TWAT")

        other = threading.Thread(target=read)
        other.start()
        try:
            for _ in range(20):
                it.car.faults[:] = FAULTS
                assert ecu.erase_faults().after == ()
        finally:
            stop.set()
            other.join(30)

    @pytest.mark.parametrize(
        "change",
        [
            lambda ecu: ecu.raw(b"\x99"),
            lambda ecu: ecu.set_list("TWAT"),
            lambda ecu: ecu.read_list(),
            lambda ecu: ecu.erase_faults(),
        ],
    )
    def test_a_change_in_a_stream_does_not_wait_for_who_waits_for_the_stream(self, change):
        asked = threading.Event()
        ecu = ecu_on(bench(), confirm=lambda _: asked.set() or True)
        ecu.set_list("TWAT")
        asked.clear()
        samples = ecu.watch("TWAT", method="stream")
        next(samples)
        # It holds the gate and the list, and waits for the end of the stream.
        other = threading.Thread(target=lambda: ecu.set_list("FREQ"))
        other.start()
        assert asked.wait(30)
        with pytest.raises(UsageError, match="stream"):
            change(ecu)
        samples.close()
        other.join(30)
        assert list(ecu.read_list()) == ["FREQ"]


@pytest.mark.parametrize("name", CHANGES)
def test_an_adapter_that_is_gone_leaves_the_change_unknown(name):
    it = bench()

    def unplug(change):
        it.link.unplug()
        return True

    with pytest.raises(LinkLost) as lost:
        CHANGES[name](ecu_on(it, confirm=unplug))
    assert "unknown" in lost.value.advice.en
    assert "неизвестно" in lost.value.advice.ru
