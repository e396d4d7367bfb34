"""Adding: what is skipped, what replaces what, what is passed over; nothing counts twice."""

from __future__ import annotations

import errno
import json
import os
import threading
from dataclasses import replace

import pytest

from fleet_rig import BEGAN, DAY, SETTINGS, HereRunner, add_here, ask, counts, files_of, make
from mikas.catalog import load
from mikas.client.cars import CarDetails
from mikas.errors import FleetError, UsageError
from mikas.fleet.adding import add, plan
from mikas.fleet.interpreting import InterpretingSettings
from mikas.fleet.job import LARGEST
from mikas.fleet.ledger import FOLDER, MARKER, begin, open_ledger
from mikas.fleet.stores import DiskStore, store
from mikas.recording.annotations.events import car_note
from mikas.recording.capture.writer import append_note

TOTAL = "SELECT count(*), count(DISTINCT drive), (SELECT count(*) FROM drives) FROM samples"


def one_drive(dataset, rows: int = 239) -> None:
    """Whether there is one drive in the dataset, once."""
    assert ask(dataset, TOTAL) == [(rows, 1, 1)]
    named = {name for it in open_ledger(store(str(dataset))).entries.values() for name in it.files}
    assert files_of(dataset) == named
    assert not list((dataset / ".parts").glob("*"))


def test_the_same_file_again_is_skipped(tmp_path) -> None:
    make(tmp_path / "in" / "deep" / "drive.PCAPNG")
    (tmp_path / "in" / "notes.txt").write_text("not looked at")
    assert counts(add_here(tmp_path / "in", to=tmp_path / "set")) == (1, 0, 0, 0)
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / "set").rglob("*")}
    assert counts(add_here(tmp_path / "in", to=tmp_path / "set")) == (0, 0, 1, 0)
    assert before == {path: path.stat().st_mtime_ns for path in (tmp_path / "set").rglob("*")}
    one_drive(tmp_path / "set")


def test_a_copy_is_the_same_recording(tmp_path) -> None:
    file = make(tmp_path / "a" / "drive.pcapng")
    (tmp_path / "copy.pcapng").write_bytes(file.read_bytes())
    result = add_here(tmp_path / "a", tmp_path / "copy.pcapng", to=tmp_path / "set")
    assert counts(result) == (1, 0, 1, 0)
    one_drive(tmp_path / "set")
    os.utime(tmp_path / "copy.pcapng", (1, 1))
    assert counts(add_here(tmp_path / "copy.pcapng", to=tmp_path / "set")) == (0, 0, 1, 0)


def test_a_recording_that_has_grown_replaces_its_beginning(tmp_path) -> None:
    whole = make(tmp_path / "whole.pcapng").read_bytes()
    file = tmp_path / "drive.pcapng"
    file.write_bytes(whole[: len(whole) // 2])
    result = add_here(file, to=tmp_path / "set")
    assert counts(result) == (1, 0, 0, 0)
    file.write_bytes(whole)
    assert counts(add_here(file, to=tmp_path / "set")) == (1, 1, 0, 0)
    one_drive(tmp_path / "set")
    file.write_bytes(whole[: len(whole) // 2])  # an old copy comes again
    assert counts(add_here(file, to=tmp_path / "set")) == (0, 0, 1, 0)
    one_drive(tmp_path / "set")


def test_a_beginning_next_to_the_whole_recording_does_not_count(tmp_path) -> None:
    whole = make(tmp_path / "in" / "whole.pcapng")
    half = whole.read_bytes()[: whole.stat().st_size // 2]
    (tmp_path / "in" / "a half.pcapng").write_bytes(half)
    assert counts(add_here(tmp_path / "in", to=tmp_path / "set")) == (2, 1, 0, 0)
    one_drive(tmp_path / "set")
    (tmp_path / "later.pcapng").write_bytes(half[:-100])
    both = (tmp_path / "later.pcapng", tmp_path / "in")
    assert counts(add_here(*both, to=tmp_path / "set")) == (0, 0, 3, 0)
    one_drive(tmp_path / "set")
    places = [str(tmp_path / "later.pcapng"), str(tmp_path / "in")]
    assert plan(places, str(tmp_path / "set"), SETTINGS).files == ()  # nothing is read again


def test_a_name_as_long_as_can_be_ends_nothing(tmp_path) -> None:
    make(tmp_path / "in" / "1.pcapng", plate="", car="🚗" * 60)
    make(tmp_path / "in" / "2.pcapng", began=BEGAN + DAY)
    assert counts(add_here(tmp_path / "in", to=tmp_path / "set")) == (2, 0, 0, 0)
    assert ask(tmp_path / "set", "SELECT count(DISTINCT car) FROM drives") == [(2,)]


def test_copies_that_two_workers_read_at_once_count_once(tmp_path) -> None:
    file = make(tmp_path / "in" / "a.pcapng")
    (tmp_path / "in" / "b.pcapng").write_bytes(file.read_bytes())
    planned = plan([str(tmp_path / "in")], str(tmp_path / "set"), SETTINGS)

    class Both(HereRunner):
        def outcomes(self, work, files):
            yield from [work(it) for it in files]  # before the first of them counts

    result = add(planned, str(tmp_path / "set"), SETTINGS, Both())
    assert counts(result) == (1, 0, 1, 0)
    one_drive(tmp_path / "set")
    assert plan([str(tmp_path / "in")], str(tmp_path / "set"), SETTINGS).files == ()


def test_a_note_at_the_end_moves_a_recording_to_another_car(tmp_path) -> None:
    file = make(tmp_path / "drive.pcapng")
    add_here(file, to=tmp_path / "set")
    append_note(file, car_note(BEGAN, CarDetails(plate="Е777КХ99")))
    assert counts(add_here(file, to=tmp_path / "set")) == (1, 1, 0, 0)
    one_drive(tmp_path / "set")
    assert ask(tmp_path / "set", "SELECT DISTINCT car FROM samples") == [("E777KX99",)]
    assert not list((tmp_path / "set").glob("*/car=A101MP52"))


def test_a_file_changed_where_it_lies_is_replaced_and_another_of_its_name_is_not(tmp_path) -> None:
    file = make(tmp_path / "drive.pcapng")
    add_here(file, to=tmp_path / "set")
    changed = bytearray(file.read_bytes())
    changed[-20] ^= 0xFF
    file.write_bytes(changed)
    assert counts(add_here(file, to=tmp_path / "set"))[:2] == (1, 1)
    assert len(open_ledger(store(str(tmp_path / "set"))).entries) == 1
    make(file, began=BEGAN + DAY)  # another stick, with a file of the same name
    assert counts(add_here(file, to=tmp_path / "set")) == (1, 0, 0, 0)
    assert len(open_ledger(store(str(tmp_path / "set"))).entries) == 2


def test_another_catalog_interprets_again(tmp_path) -> None:
    file = make(tmp_path / "drive.pcapng")
    add_here(file, to=tmp_path / "set")
    own = tmp_path / "own.toml"
    own.write_text("[parameter.TWAT]\noffset = -39\n")
    ((before,),) = ask(tmp_path / "set", "SELECT avg(TWAT) FROM samples")
    changed = InterpretingSettings(load(own))
    assert counts(add_here(file, to=tmp_path / "set", settings=changed)) == (1, 1, 0, 0)
    one_drive(tmp_path / "set")
    ((after,),) = ask(tmp_path / "set", "SELECT avg(TWAT) FROM samples")
    assert after == pytest.approx(before + 1)
    assert counts(add_here(file, to=tmp_path / "set", settings=changed)) == (0, 0, 1, 0)


def test_a_given_car_stays_until_another_is_given(tmp_path) -> None:
    file = make(tmp_path / "drive.pcapng")
    given = replace(SETTINGS, car="Служебная")
    assert counts(add_here(file, to=tmp_path / "set", settings=given)) == (1, 0, 0, 0)
    assert counts(add_here(file, to=tmp_path / "set")) == (0, 0, 1, 0)
    literal = InterpretingSettings(SETTINGS.catalog, "literal")
    assert counts(add_here(file, to=tmp_path / "set", settings=literal)) == (1, 1, 0, 0)
    assert ask(tmp_path / "set", "SELECT car FROM drives") == [("СЛУЖЕБНАЯ",)]


def hostile(folder) -> set[str]:
    """A folder of files that are no recordings, or none to read; their names."""
    folder.mkdir()
    good = make(folder / "good.pcapng").read_bytes()
    (folder / "empty.pcapng").write_bytes(b"")
    (folder / "text.pcapng").write_text("not a recording")
    (folder / "zip.pcapng").write_bytes(b"PK\x03\x04" + bytes(500))
    (folder / "only a header.pcapng").write_bytes(good[:28])
    (folder / "old.pcapng").write_bytes(bytes.fromhex("d4c3b2a1") + bytes(100))
    with (folder / "huge.pcapng").open("wb") as file:
        file.write(good)
        file.truncate(LARGEST + 1)
    names = {path.name for path in folder.iterdir()} - {"good.pcapng"}
    if os.name == "posix":
        (folder / "link.pcapng").symlink_to("/etc/hostname")
        (folder / "nowhere.pcapng").symlink_to("gone")
        (folder / "loop").symlink_to(folder)
        os.mkfifo(folder / "pipe.pcapng")
        (folder / "\x1b[31mred.pcapng").write_bytes(b"")
        names |= {"link.pcapng", "nowhere.pcapng", "pipe.pcapng", "\x1b[31mred.pcapng"}
    return names


def test_bad_files_are_named_and_passed_over(tmp_path) -> None:
    bad = hostile(tmp_path / "in")
    (tmp_path / "in" / "folder.pcapng").mkdir()
    result = add_here(tmp_path / "in", to=tmp_path / "set")
    assert {it.file.rpartition("/")[2] for it in result.bad} == bad
    assert all(it.reason.en and it.reason.ru for it in result.bad)
    assert not any("bug" in it.reason.en for it in result.bad)
    assert result.added == 1
    one_drive(tmp_path / "set")
    assert len(add_here(tmp_path / "in", to=tmp_path / "set").bad) == len(bad)


def test_a_full_disk_ends_the_run_and_what_was_finished_stays(tmp_path, monkeypatch) -> None:
    for number in range(4):
        make(tmp_path / "in" / f"{number}.pcapng", began=BEGAN + number * DAY)
    add_here(tmp_path / "in" / "0.pcapng", to=tmp_path / "set")
    full = OSError(errno.ENOSPC, "No space left on device")

    def fail(*given) -> None:
        raise full

    with monkeypatch.context() as patched:
        patched.setattr("mikas.fleet.stores.DiskStore._rename", fail)
        with pytest.raises(FleetError, match="make room") as failed:
            add_here(tmp_path / "in", to=tmp_path / "set")
        assert failed.value.place == str(tmp_path / "set")
    assert ask(tmp_path / "set", TOTAL) == [(239, 1, 1)]
    assert counts(add_here(tmp_path / "in", to=tmp_path / "set")) == (3, 0, 1, 0)


def test_ctrl_c_while_an_entry_is_written_leaves_no_part_of_it(tmp_path, monkeypatch) -> None:
    def interrupted(_: int) -> None:
        raise KeyboardInterrupt

    files = store(str(tmp_path / "set"))
    monkeypatch.setattr("os.fsync", interrupted)
    with pytest.raises(KeyboardInterrupt):
        files.write("_ledger/a.json", b"{}")
    assert [each for each in (tmp_path / "set").rglob("*") if each.is_file()] == []


def test_damage_inside_is_counted_and_the_rest_is_added(tmp_path) -> None:
    file = make(tmp_path / "drive.pcapng")
    data = bytearray(file.read_bytes())
    middle = len(data) // 2
    data[middle : middle + 300] = bytes(300)
    file.write_bytes(data)
    result = add_here(file, to=tmp_path / "set")
    assert [count > 0 for _, count in result.damaged] == [True]
    ((rows, damaged),) = ask(tmp_path / "set", "SELECT rows, damaged_places FROM drives")
    assert damaged == result.damaged[0][1]
    assert 200 < rows < 239


def test_what_is_no_place_or_no_dataset_is_said(tmp_path) -> None:
    with pytest.raises(FleetError, match="no such file or folder"):
        add_here(tmp_path / "nothing", to=tmp_path / "set")
    assert not (tmp_path / "set").exists()
    (tmp_path / "in").mkdir()
    assert counts(add_here(tmp_path / "in", to=tmp_path / "set")) == (0, 0, 0, 0)
    (tmp_path / "home").mkdir()
    (tmp_path / "home" / "letter.txt").write_text("dear")
    with pytest.raises(FleetError, match="other files"):
        add_here(tmp_path / "in", to=tmp_path / "home")
    (tmp_path / "file").write_text("")
    with pytest.raises(FleetError):
        add_here(tmp_path / "in", to=tmp_path / "file")
    with pytest.raises(FleetError, match="no dataset"):
        open_ledger(store(str(tmp_path / "home")))
    (tmp_path / "set" / MARKER).write_text('{"form": 99}')
    with pytest.raises(FleetError, match="later version"):
        add_here(tmp_path / "in", to=tmp_path / "set")


def test_a_dataset_and_a_car_without_a_name_are_refused(tmp_path) -> None:
    make(tmp_path / "in" / "drive.pcapng")
    with pytest.raises(FleetError, match="must be UTF-8"):
        add_here(tmp_path / "in", to=tmp_path / "set\udcff")
    with pytest.raises(UsageError, match="no letter and no digit"):
        add_here(tmp_path / "in", to=tmp_path / "set", settings=replace(SETTINGS, car="--"))
    assert [path.name for path in tmp_path.iterdir()] == ["in"]


def test_a_channel_may_not_be_called_as_a_column(tmp_path) -> None:
    own = tmp_path / "own.toml"
    own.write_text('[parameter.DAY]\ncode = 0x33\nsize = 1\ntext = { en = "Day", ru = "День" }\n')
    with pytest.raises(UsageError, match="DAY"):
        add_here(tmp_path, to=tmp_path / "set", settings=InterpretingSettings(load(own)))


def test_two_runs_at_once_add_each_recording_once(tmp_path) -> None:
    for number in range(4):
        make(tmp_path / "in" / f"{number}.pcapng", began=BEGAN + number * DAY)
    results: list = []
    runs = [
        threading.Thread(
            target=lambda: results.append(add_here(tmp_path / "in", to=tmp_path / "set"))
        )
        for _ in range(3)
    ]
    for run in runs:
        run.start()
    for run in runs:
        run.join()
    assert len(results) == 3
    assert not any(it.bad for it in results)
    assert ask(tmp_path / "set", TOTAL) == [(4 * 239, 4, 4)]
    assert counts(add_here(tmp_path / "in", to=tmp_path / "set")) == (0, 0, 4, 0)


def test_two_runs_may_begin_a_dataset_in_one_moment(tmp_path) -> None:
    """The other one writes the marker after this one has found none."""

    class Late(DiskStore):
        def read(self, name: str, most: int) -> bytes | None:
            content = super().read(name, most)
            if content is None:
                begin(store(self.place))
            return content

    assert begin(Late(str(tmp_path / "set"))).entries == {}


def test_a_damaged_or_hostile_ledger_touches_no_other_file(tmp_path) -> None:
    file, outside = make(tmp_path / "drive.pcapng"), tmp_path / "outside.parquet"
    outside.write_text("keep")
    add_here(file, to=tmp_path / "set")
    (entry,) = (tmp_path / "set" / FOLDER).iterdir()
    sound = json.loads(entry.read_text("utf-8"))
    for changed in (
        {"obsolete": ["../outside.parquet"]},
        {"obsolete": ["samples/car=../../../outside.parquet"]},
        {"files": ["samples/car=x/day=../../../../outside.parquet"]},
        {"files": 7}, {"bytes": "many"}, {"key": "../x"}, {"sources": []},
        {"sources": {"/a": []}}, {"heads": 7}, {"replaces": [sound["key"]]},
    ):  # fmt: skip
        entry.write_text(json.dumps(sound | changed))
        assert counts(add_here(file, to=tmp_path / "set"))[0] == 1, changed
    entry.write_text('{"half')
    assert counts(add_here(file, to=tmp_path / "set"))[0] == 1
    assert outside.read_text() == "keep"
    one_drive(tmp_path / "set")
