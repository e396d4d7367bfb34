"""A dump written back: only what differs, read back; whatever ends it, nothing wrong is claimed."""

from __future__ import annotations

import json

import pytest
from client_harness import bench, ecu_on, lines
from hypothesis import given, settings
from hypothesis import strategies as st

from mikas.client.memory.dumps import Difference, Dump
from mikas.client.memory.restoring import DumpFile, Restore, _places, _runs
from mikas.errors import (
    EcuRefused,
    MikasError,
    NoConnection,
    NotConfirmed,
    ReadBackDiffers,
    UsageError,
)
from mikas.saving import save
from mikas.virtual.fault_injector import FaultInjector, LineFault
from mikas.virtual.responder import Identity

BYTES = [0x40, 0x41, 0x42, 0x50, 0x7F]  # changed in the dump


def nothing(_: int) -> None:
    pass


def dumped(it, folder, space="ram", first=0x20, last=0x9F, changed=BYTES) -> bytes:
    """Dump a part of `space` into FILE `d`, then change the bytes at these addresses in it."""
    file = folder / "d"
    with ecu_on(it) as ecu:
        Dump(ecu, ecu.memory[space], file, first=first, last=last, resume=False).advance(
            block=None, progress=nothing
        )
    data = bytearray(file.read_bytes())
    for address in changed:
        data[address - first] ^= 0x4D
    file.write_bytes(data)
    return bytes(data)


def job_on(ecu, folder, space="ram", *, resume=False, **how) -> Restore:
    dump = DumpFile.read(folder / "d", space, **how)
    job = Restore(ecu, ecu.memory[space], dump, resume=resume)
    job.compare(block=None, progress=nothing)
    return job


def restored(it, folder, space="ram", *, resume=False, confirm=lambda _: True, **how) -> Restore:
    with ecu_on(it, confirm=confirm, journal=folder / "journal") as ecu:
        job = job_on(ecu, folder, space, resume=resume, **how)
        list(job.write())
        return job


def stored(it, space="ram", first=0x20, count=0x80) -> bytes:
    with ecu_on(it) as ecu:
        return ecu.memory[space].read_block(first, count)


@pytest.mark.parametrize("space", ["ram", "xram", "code", "sfr"])
@pytest.mark.parametrize(
    "quirks", [{}, {"missing": "blocks"}, {"max_block": 2}, {"missing": "11,12,13,14,15,16"}]
)
def test_only_what_differs_is_written(tmp_path, space, quirks):
    it = bench(**quirks)
    data = dumped(it, tmp_path, space)
    with ecu_on(it, confirm=lambda _: True, journal=tmp_path / "journal") as ecu:
        job = job_on(ecu, tmp_path, space)
        it.forget()
        assert sum(job.write()) == job.written == len(BYTES)
        sent = [body for code in (0x12, 0x14, 0x16, 0x22, 0x24, 0x26, 0x32)
                for body in it.requests(code)]  # fmt: skip
        wide = space in ("xram", "code")
        to = {int.from_bytes(b[1 : 3 if wide else 2], "little") for b in sent}
        assert to <= set(BYTES)
    assert (job.same, job.differences) == (len(data) - len(BYTES), [])
    assert stored(it, space) == data
    assert not job.is_interrupted
    done = [entry for entry in lines(tmp_path / "journal") if entry["state"] == "done"]
    assert sum(len(bytes.fromhex(entry["outcome"])) for entry in done) == len(BYTES)
    assert all(entry["before"] != entry["outcome"] == entry["after"] for entry in done)


def test_one_question_says_how_many_bytes_differ_and_where(tmp_path):
    it, asked = bench(), []
    dumped(it, tmp_path)
    restored(it, tmp_path, confirm=lambda change: asked.append(change) or True)
    (change,) = asked
    assert "of 128 bytes 5 differ (0040–0042, 0050, 007F)" in change.what.en
    assert change.safety.name == "REVERSIBLE"


def test_another_change_meanwhile_is_asked_about(tmp_path):
    it, asked = bench(), []
    dumped(it, tmp_path)
    with ecu_on(it, confirm=lambda change: asked.append(change) or True) as ecu:
        writing = job_on(ecu, tmp_path).write()
        next(writing)
        ecu.memory.ram.write(0x10, 1)
        assert len(asked) == 2


def test_nothing_to_write_asks_nothing(tmp_path):
    it = bench()
    dumped(it, tmp_path, changed=())
    job = restored(it, tmp_path, confirm=lambda _: pytest.fail("asked"))
    assert (job.written, job.same) == (0, 128)


@pytest.mark.parametrize(("space", "confirm"), [("ram", lambda _: False), ("code", None)])
def test_without_a_yes_nothing_is_written(tmp_path, space, confirm):
    it = bench()
    dumped(it, tmp_path, space)
    before = stored(it, space)
    with pytest.raises(NotConfirmed):
        restored(it, tmp_path, space, confirm=confirm)
    assert stored(it, space) == before
    assert not list(tmp_path.glob("*.restore.json"))


@pytest.mark.parametrize("missing", ["", "blocks"])
def test_pulled_out_anywhere_resuming_ends_as_if_uninterrupted(tmp_path, missing):
    """What counts as written is in the unit; resuming compares, and ends as if uninterrupted."""
    it = bench(missing=missing)
    data = dumped(it, tmp_path)
    for stop in range(0, len(BYTES) * 9, 2):
        it.bus.ecu.responder.memory.power_cycle()
        with ecu_on(it, confirm=lambda _: True) as ecu:
            job = job_on(ecu, tmp_path, resume=True)
            write, left = ecu.tester.link.write, stop

            def cut(frame, write=write, ecu=ecu):
                nonlocal left
                if not left:
                    ecu.tester.link.unplug()
                left -= 1
                write(frame)

            ecu.tester.link.write = cut
            try:
                list(job.write())
            except NoConnection:
                assert job.is_interrupted
            else:
                break
        now = stored(it)
        taken = sum(now[a - 0x20] == data[a - 0x20] for a in BYTES)
        assert job.written <= taken
        with pytest.raises(UsageError, match="interrupted"):
            restored(it, tmp_path)
        again = restored(it, tmp_path, resume=True)
        assert stored(it) == data
        assert again.written == len(BYTES) - taken
        assert not again.is_interrupted
    assert stop > 5


def test_a_declined_resumption_keeps_the_state(tmp_path):
    it = bench()
    dumped(it, tmp_path)
    with ecu_on(it, confirm=lambda _: True) as ecu:
        writing = job_on(ecu, tmp_path).write()
        next(writing)
        ecu.tester.link.unplug()
        with pytest.raises(NoConnection):
            next(writing)
    state = json.loads((tmp_path / "d.restore.json").read_text("utf-8"))
    assert (state["different"], state["written"]) == (5, 3)
    with pytest.raises(NotConfirmed):
        restored(it, tmp_path, resume=True, confirm=lambda _: False)
    assert (tmp_path / "d.restore.json").exists()


class _Cells:
    """The unit's memory with `fixed` cells that keep their values."""

    def __init__(self, memory, fixed):
        self._memory, self._fixed = memory, fixed

    def __getattr__(self, name):
        return getattr(self._memory, name)

    def write(self, space, address, data):
        for offset, value in enumerate(data):
            if address + offset not in self._fixed:
                self._memory.write(space, address + offset, bytes([value]))


class _Truthful:
    """A unit that answers 12 with the byte that the cell has afterwards."""

    def __init__(self, responder):
        self._responder = responder

    def __getattr__(self, name):
        return getattr(self._responder, name)

    def answer(self, body, now):
        answer = self._responder.answer(body, now)
        return self._responder.answer(b"\x11" + body[1:2], now) if body[:1] == b"\x12" else answer


@pytest.mark.parametrize(("missing", "truthful"), [("", 0), ("blocks", 0), ("blocks", 1)])
def test_a_cell_that_keeps_its_value_is_a_difference_and_ends_nothing(tmp_path, missing, truthful):
    it = bench(missing=missing)
    data = dumped(it, tmp_path)
    kept = stored(it)[0x41 - 0x20]
    it.bus.ecu.responder.memory = _Cells(it.bus.ecu.responder.memory, {0x41})
    if truthful:
        it.bus.ecu.responder = _Truthful(it.bus.ecu.responder)
    job = restored(it, tmp_path)
    to = [body[1] for body in it.requests(0x12)]
    assert job.differences == [Difference(0x41, kept, data[0x41 - 0x20])]
    assert job.written == len(BYTES) - 1
    assert all(to.count(address) <= 1 for address in BYTES if address != 0x41)
    now = stored(it)
    assert [a for a in BYTES if now[a - 0x20] != data[a - 0x20]] == [0x41]


def test_a_memory_that_takes_nothing_is_given_up_soon(tmp_path):
    it = bench()
    dumped(it, tmp_path, changed=range(0x20, 0xA0, 2))
    it.bus.ecu.responder.memory = _Cells(it.bus.ecu.responder.memory, range(0x100))
    with pytest.raises(ReadBackDiffers, match="Nothing was changed"):
        restored(it, tmp_path)
    assert len(it.requests(0x12)) + len(it.requests(0x22)) <= 6
    assert not (tmp_path / "d.restore.json").exists()


@pytest.mark.parametrize("unknown", ["silent", "01"])
def test_a_unit_that_refuses_writes_is_as_it_was(tmp_path, unknown):
    it = bench(missing="12,22", unknown=unknown)
    dumped(it, tmp_path)
    before = stored(it)
    with pytest.raises(EcuRefused):
        restored(it, tmp_path)
    assert stored(it) == before


@settings(max_examples=40)
@given(st.lists(st.sampled_from([None, None, *LineFault]), max_size=20))
def test_a_bad_line_claims_nothing(tmp_path_factory, line_faults):
    folder = tmp_path_factory.mktemp("restore")
    it = bench()
    data = dumped(it, folder)
    with ecu_on(it, confirm=lambda _: True) as ecu:
        job = job_on(ecu, folder)
        it.next_faults(*line_faults)
        try:
            list(job.write())
        except MikasError:
            assert job.is_interrupted
        else:
            assert job.written + len(job.differences) == len(BYTES)
    it.bus.fault_injector = FaultInjector()
    now = stored(it)
    assert sum(now[a - 0x20] == data[a - 0x20] for a in BYTES) >= job.written
    assert all(now[i] == data[i] for i in range(0x80) if i + 0x20 not in BYTES)


def test_a_state_that_can_not_be_deleted_is_said(tmp_path, said):
    it, state = bench(), tmp_path / "d.restore.json"
    data = dumped(it, tmp_path)
    with ecu_on(it, confirm=lambda _: True) as ecu:
        for _ in (job := job_on(ecu, tmp_path)).write():
            if state.is_file():
                state.unlink()
                state.mkdir()
    assert (job.written, stored(it)) == (len(BYTES), data)
    (sentence,) = said
    assert sentence.en.startswith(f"{state} can't be deleted (")
    assert "--resume" in sentence.ru


def test_a_disk_that_fills_up_stops_nothing_half_way(tmp_path, monkeypatch):
    it = bench()
    data = dumped(it, tmp_path)
    written = []

    def once(path, text):
        written.append(path)
        if len(written) > 1:
            raise OSError(28, "No space left on device")
        save(path, text)

    monkeypatch.setattr("mikas.client.memory.restoring.save", once)
    restored(it, tmp_path)
    assert stored(it) == data
    assert not (tmp_path / "d.restore.json").exists()
    (tmp_path / "d").write_bytes(bytes(0x80))
    with pytest.raises(UsageError, match="No space left"):  # before anything is written
        restored(it, tmp_path)
    assert stored(it) == data


class TestTheFile:
    def test_a_dump_of_another_unit_space_or_size_is_refused(self, tmp_path):
        it = bench()
        data = dumped(it, tmp_path)
        with pytest.raises(UsageError, match="of ram, not of xram"):
            restored(it, tmp_path, "xram")
        other = bench(identity=Identity(0x0A, ("another",) * 8))
        with pytest.raises(UsageError, match="another unit"):
            restored(other, tmp_path)
        with pytest.raises(UsageError, match="0020, by its manifest"):
            restored(it, tmp_path, first=0)
        (tmp_path / "d").write_bytes(data[:-1])
        with pytest.raises(UsageError, match="127 bytes, its manifest says 128"):
            restored(it, tmp_path)
        (tmp_path / "d").write_bytes(b"")
        with pytest.raises(UsageError, match="empty"):
            restored(it, tmp_path)

    def test_the_manifest_may_be_ignored_with_an_address(self, tmp_path):
        it = bench()
        data = dumped(it, tmp_path)
        (tmp_path / "d.json").write_text("no manifest", "utf-8")
        with pytest.raises(UsageError, match="no manifest"):
            restored(it, tmp_path)
        (tmp_path / "d.json").unlink()
        with pytest.raises(UsageError, match="no manifest beside it"):
            restored(it, tmp_path)
        with pytest.raises(UsageError, match="--from"):
            restored(it, tmp_path, ignore_manifest=True)
        with pytest.raises(UsageError, match="exceed"):
            restored(it, tmp_path, ignore_manifest=True, first=0xA0)
        restored(it, tmp_path, ignore_manifest=True, first=0x20)
        assert stored(it) == data

    def test_a_changed_file_is_recognized(self, tmp_path):
        dumped(bench(), tmp_path)
        assert DumpFile.read(tmp_path / "d", "ram").changed
        (tmp_path / "d").unlink()
        (tmp_path / "d.json").unlink()
        dumped(bench(), tmp_path, changed=())
        assert not DumpFile.read(tmp_path / "d", "ram").changed


@given(st.binary(min_size=1, max_size=60), st.randoms(), st.integers(1, 10))
def test_runs_are_the_differences(before, random, longest):
    after = bytes(b ^ random.choice([0, 0, 1]) for b in before)
    found = [
        Difference(i, a, b) for i, (a, b) in enumerate(zip(before, after, strict=True)) if a != b
    ]
    runs = list(_runs(found, longest))
    unit = bytearray(before)
    for run in runs:
        assert 1 <= len(run.data) <= longest
        assert unit[run.address : run.address + len(run.data)] == run.before
        unit[run.address : run.address + len(run.data)] = run.data
    assert unit == after
    assert sum(len(run.data) for run in runs) == len(found)
    starts = {d.address for d in found} - {d.address + 1 for d in found}
    assert [int(place[:4], 16) for place in _places(runs)] == sorted(starts)
