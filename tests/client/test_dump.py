"""Dumps: what is in the file and its manifest, whatever happens on the way; comparing."""

from __future__ import annotations

import json
from contextlib import suppress

import pytest
from client_harness import bench, ecu_on
from hypothesis import given
from hypothesis import strategies as st

from mikas.client.memory.dumps import (
    Difference,
    Dump,
    compare,
    differences,
    manifest_path,
    read_manifest,
)
from mikas.errors import AddressOutOfRange, LineError, NoConnection, UsageError
from mikas.files.locks import hold


def nothing(_: int) -> None:
    pass


def dump(ecu, file, space="ram", first=0, last=255, *, resume=False) -> Dump:
    return Dump(ecu, ecu.memory[space], file, first=first, last=last, resume=resume)


@pytest.fixture
def ecu():
    with ecu_on(bench()) as connected:
        yield connected


@pytest.mark.parametrize("space", ["ram", "xram", "code", "sfr"])
def test_what_is_read_is_what_is_there(ecu, tmp_path, space):
    done = []
    job = dump(ecu, tmp_path / "d", space, 0x10, 0x8F)
    job.advance(block=50, progress=done.append)
    assert (tmp_path / "d").read_bytes() == ecu.memory[space].read_block(0x10, 0x80)
    assert sum(done) == 0x80
    assert max(done) <= 50
    manifest = read_manifest(tmp_path / "d")
    assert manifest == job.manifest
    assert (manifest.complete, manifest.verified, manifest.bytes_read) == (True, None, 0x80)


def test_nothing_is_made_before_the_range_is_known_to_be_right(ecu, tmp_path):
    for first, last in ((0, 256), (-1, 5)):
        with pytest.raises(AddressOutOfRange):
            dump(ecu, tmp_path / "d", "ram", first, last)
    with pytest.raises(UsageError, match="the last address, 0008, is before the first, 0009"):
        dump(ecu, tmp_path / "d", "ram", 9, 8)
    with pytest.raises(UsageError, match="1 to 255"):
        dump(ecu, tmp_path / "d").advance(block=300, progress=print)
    assert not list(tmp_path.iterdir())


def test_after_an_interruption_at_any_block_the_dump_ends_the_same(tmp_path):
    """Whatever stops it, what was read stays, and the end is the same as without it."""
    it = bench()
    with ecu_on(it) as ecu:
        whole = ecu.memory.ram.read_block(0, 256)
    file = tmp_path / "d"
    for stop in range(1, 9):
        with ecu_on(it) as ecu:
            job = dump(ecu, file, resume=stop > 1)

            def pull_out(count: int, job=job, ecu=ecu, stop=stop) -> None:
                if job.manifest.bytes_read >= 32 * stop:
                    ecu.tester.link.unplug()

            if stop < 8:
                with pytest.raises(NoConnection):
                    job.advance(block=32, progress=pull_out)
                manifest = read_manifest(file)
                assert (manifest.bytes_read, manifest.complete) == (32 * stop, False)
                assert manifest.sha256 is None
            else:
                job.advance(block=32, progress=nothing)
        assert file.read_bytes() == whole[: 32 * stop]
    assert read_manifest(file).complete


def test_ctrl_c_keeps_what_was_read(ecu, tmp_path):
    def interrupted(_: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        dump(ecu, tmp_path / "d").advance(block=16, progress=interrupted)
    assert (read_manifest(tmp_path / "d").bytes_read, (tmp_path / "d").stat().st_size) == (16, 16)


def test_a_dump_with_an_old_manifest_is_completed(ecu, tmp_path):
    file = tmp_path / "d"
    dump(ecu, file).advance(block=None, progress=nothing)
    whole = file.read_bytes()
    manifest = json.loads(manifest_path(file).read_text("utf-8"))
    manifest |= {"bytes_read": 0, "complete": False, "sha256": None}
    manifest_path(file).write_text(json.dumps(manifest), "utf-8")
    file.write_bytes(whole[:77])
    dump(ecu, file, resume=True).advance(block=None, progress=nothing)
    assert file.read_bytes() == whole


def test_a_second_pass_that_differs_is_reported(tmp_path):
    it = bench()
    with ecu_on(it, confirm=lambda _: True, journal=tmp_path / "journal") as ecu:
        job = dump(ecu, tmp_path / "d")
        job.advance(block=None, progress=nothing)
        before = ecu.memory.ram.read(0x40)
        ecu.memory.ram.write(0x40, before ^ 0xFF)
        assert job.verify(block=None, progress=nothing) == [Difference(0x40, before ^ 0xFF, before)]
        assert read_manifest(tmp_path / "d").verified is False


def test_another_unit_is_not_mixed_in(tmp_path):
    with ecu_on(bench()) as ecu, pytest.raises(KeyboardInterrupt):
        dump(ecu, tmp_path / "d").advance(block=16, progress=_interrupt)
    from mikas.virtual.responder import Identity

    other = bench(identity=Identity(0x0A, ("another",) * 8))
    with ecu_on(other) as ecu, pytest.raises(UsageError, match="another unit"):
        dump(ecu, tmp_path / "d", resume=True)


def _interrupt(_: int) -> None:
    raise KeyboardInterrupt


def test_a_unit_without_blocks_is_dumped_and_one_without_memory_is_not(tmp_path):
    with ecu_on(bench(missing="blocks")) as ecu:
        dump(ecu, tmp_path / "a", last=7).advance(block=None, progress=nothing)
        assert (tmp_path / "a").read_bytes() == ecu.memory.ram.read_block(0, 8)
    with ecu_on(bench(missing="blocks,bytes")) as ecu:
        job = dump(ecu, tmp_path / "b", last=7)
        with pytest.raises(Exception, match="does not know"):
            job.advance(block=None, progress=nothing)
        assert (tmp_path / "b").read_bytes() == b""
        assert read_manifest(tmp_path / "b").bytes_read == 0


def test_a_spoilt_line_keeps_only_sound_bytes(tmp_path):
    it = bench()
    with ecu_on(it) as ecu:
        whole = ecu.memory.ram.read_block(0, 256)
    from mikas.virtual.fault_injector import FaultInjector, LineFault

    for seed in range(5):
        it.bus.fault_injector = FaultInjector()
        with ecu_on(it, retries=3) as ecu:
            it.bus.fault_injector = FaultInjector({LineFault.DAMAGED: 0.3}, seed=seed)
            file = tmp_path / f"{seed}"
            with suppress(LineError):
                dump(ecu, file).advance(block=16, progress=nothing)
            assert not file.exists() or whole.startswith(file.read_bytes())


def test_a_dump_into_a_missing_folder_is_an_error(ecu, tmp_path):
    with pytest.raises(UsageError, match="nosuch"):
        dump(ecu, tmp_path / "nosuch" / "d").advance(block=None, progress=nothing)


@given(st.binary(max_size=40), st.integers(0, 30), st.binary(max_size=40), st.integers(0, 30))
def test_differences_are_all_addresses_that_differ_or_lack_a_side(a, first_a, b, first_b):
    left = {first_a + at: value for at, value in enumerate(a)}
    right = {first_b + at: value for at, value in enumerate(b)}
    expected = [
        Difference(at, left.get(at), right.get(at))
        for at in sorted(left | right)
        if left.get(at) != right.get(at)
    ]
    assert list(differences(a, first_a, b, first_b)) == expected


def test_compare_gives_the_addresses_that_differ(ecu):
    data = bytearray(ecu.memory.xram.read_block(0x100, 20))
    data[3] ^= 1
    data[19] ^= 1
    found = list(compare(ecu.memory.xram, bytes(data), 0x100, 7, nothing))
    assert [it.address for it in found] == [0x103, 0x113]
    assert all(it.a == it.b ^ 1 for it in found)


def test_a_dump_that_another_program_reads_is_not_continued(ecu, tmp_path):
    file = tmp_path / "ram.bin"
    job = dump(ecu, file)
    file.write_bytes(bytes(8))
    with file.open("r+b") as held:
        hold(held)
        with pytest.raises(UsageError, match="another program is writing to this file"):
            job.advance(block=None, progress=nothing)
    assert file.read_bytes() == bytes(8)
