"""States of one recording count once: beginnings, changed files, and runs that add at one time."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from fleet_rig import BEGAN, DAY, SETTINGS, HereRunner, add_here, ask, counts, files_of, make
from mikas.fleet import growing
from mikas.fleet.adding import AddingPlan, add, plan
from mikas.fleet.ledger import begin, open_ledger
from mikas.fleet.stores import DiskStore, store

ROWS = 239


def one_recording(dataset: Path, rows: int = ROWS) -> None:
    """Whether one recording with so many rows counts, and no other file is left."""
    assert ask(dataset, "SELECT count(*), count(DISTINCT drive) FROM samples") == [(rows, 1)]
    (entry,) = open_ledger(store(str(dataset))).entries.values()
    assert files_of(dataset) == set(entry.files)


def planned(*places: Path, to: Path) -> AddingPlan:
    return plan(map(str, places), str(to), SETTINGS)


def run(made: AddingPlan, to: Path) -> None:
    add(made, str(to), SETTINGS, HereRunner())


@pytest.fixture
def whole(tmp_path) -> bytes:
    return make(tmp_path / "whole" / "drive.pcapng").read_bytes()


@pytest.mark.parametrize("first", [0, 1])
def test_two_runs_with_two_states_of_a_recording_leave_the_whole_one(
    tmp_path, whole, first
) -> None:
    file, dataset = tmp_path / "drive.pcapng", tmp_path / "set"
    states = [whole[: len(whole) // 2], whole]
    plans = []
    for state in states:
        file.write_bytes(state)
        plans.append(planned(file, to=dataset))
    for at in (first, 1 - first):
        file.write_bytes(states[at])
        run(plans[at], dataset)
    file.write_bytes(whole)
    add_here(file, to=dataset)
    one_recording(dataset)


def test_runs_that_both_replace_are_settled_by_the_later_one(tmp_path, whole) -> None:
    """Three states, each added by a run that knows none of the others; the last run settles."""
    dataset = tmp_path / "set"
    plans = []
    for number, part in enumerate((3, 2, 1)):
        file = tmp_path / f"{number}.pcapng"
        file.write_bytes(whole[: len(whole) // part])
        plans.append(planned(file, to=dataset))
    for each in plans:
        run(each, dataset)
    one_recording(dataset)
    copy = tmp_path / "copy.pcapng"
    copy.write_bytes(whole[: len(whole) // 3])
    assert counts(add_here(copy, to=dataset)) == (0, 0, 1, 0)
    one_recording(dataset)


def test_a_copy_of_what_another_run_has_replaced_does_not_count_again(tmp_path, whole) -> None:
    file, copy, dataset = tmp_path / "a.pcapng", tmp_path / "copy.pcapng", tmp_path / "set"
    for each in (file, copy):
        each.write_bytes(whole[: len(whole) // 2])
    add_here(file, to=dataset)
    before = planned(copy, to=dataset)
    file.write_bytes(whole)
    add_here(file, to=dataset)
    run(before, dataset)
    one_recording(dataset)


def test_an_entry_that_a_slow_run_writes_back_does_not_count(tmp_path, whole) -> None:
    file, dataset = tmp_path / "a.pcapng", tmp_path / "set"
    file.write_bytes(whole[: len(whole) // 2])
    add_here(file, to=dataset)
    files = {each: each.read_bytes() for each in dataset.rglob("*") if each.is_file()}
    file.write_bytes(whole)
    add_here(file, to=dataset)
    for path, data in files.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    assert ask(dataset, "SELECT count(*) FROM samples") == [(ROWS,)]


def test_a_slow_run_writes_back_no_entry(tmp_path, whole) -> None:
    file, dataset = tmp_path / "a.pcapng", tmp_path / "set"
    file.write_bytes(whole[: len(whole) // 2])
    add_here(file, to=dataset)
    slow = open_ledger(store(str(dataset)))
    (key,) = slow.entries
    file.write_bytes(whole)
    add_here(file, to=dataset)
    slow.note_source(key, "/media/copy.pcapng", "1-1")
    slow.write_noted()
    assert slow.entries == {}
    one_recording(dataset)


def test_a_question_while_a_recording_is_replaced_gets_one_of_both(
    tmp_path, whole, monkeypatch
) -> None:
    file, dataset = tmp_path / "a.pcapng", tmp_path / "set"
    half = whole[: len(whole) // 2]
    file.write_bytes(half)
    add_here(file, to=dataset)
    names, read = DiskStore.names, DiskStore.read
    for moment in ("names", "read"):  # the other run ends after the list, or after the entries

        def after(self, name, *most, moment=moment, dataset=dataset):
            original = names if moment == "names" else read
            got = original(self, name, *most)
            if name.startswith("_ledger"):
                monkeypatch.undo()
                file.write_bytes(whole)
                add_here(file, to=dataset)
            return got

        monkeypatch.setattr(DiskStore, moment, after)
        assert ask(dataset, "SELECT count(*) FROM samples") == [(ROWS,)]
        one_recording(dataset)
        dataset = tmp_path / "other"
        file.write_bytes(half)
        add_here(file, to=dataset)


def test_a_sound_copy_replaces_a_damaged_one_at_its_place(tmp_path, whole) -> None:
    file, dataset = tmp_path / "drive.pcapng", tmp_path / "set"
    file.write_bytes(whole)
    add_here(file, to=dataset)
    damaged = bytearray(whole)
    damaged[len(whole) // 2 : len(whole) // 2 + 3000] = bytes(3000)
    file.write_bytes(damaged)
    assert counts(add_here(file, to=dataset)) == (1, 1, 0, 0)
    file.write_bytes(whole)
    assert counts(add_here(file, to=dataset)) == (1, 1, 0, 0)
    one_recording(dataset)


@pytest.mark.parametrize("size", [4000, 1000])
def test_a_beginning_of_a_few_rows_does_not_count_beside_the_whole(tmp_path, whole, size) -> None:
    dataset = tmp_path / "set"
    add_here(tmp_path / "whole", to=dataset)
    beginning = tmp_path / "beginning.pcapng"
    beginning.write_bytes(whole[:size])
    assert counts(add_here(beginning, tmp_path / "whole", to=dataset)) == (0, 0, 2, 0)
    one_recording(dataset)
    add_here(beginning, to=tmp_path / "other")
    assert counts(add_here(tmp_path / "whole", to=tmp_path / "other")) == (1, 1, 0, 0)
    one_recording(tmp_path / "other")


def test_a_beginning_added_alone_counts_until_the_whole_is_named_too(tmp_path, whole) -> None:
    """Where the ledger says that the whole recording lies is not opened for that."""
    dataset, beginning = tmp_path / "set", tmp_path / "beginning.pcapng"
    add_here(tmp_path / "whole", to=dataset)
    beginning.write_bytes(whole[:4000])
    assert counts(add_here(beginning, to=dataset)) == (1, 0, 0, 0)
    assert counts(add_here(beginning, tmp_path / "whole", to=dataset)) == (0, 0, 2, 0)
    one_recording(dataset)


def test_thousands_of_recordings_that_begin_alike_are_each_read_once(tmp_path, monkeypatch) -> None:
    """Tiny ones, of one head: comparing each with each took 50 s for 4,000 of them."""
    dataset, count = tmp_path / "set", 20
    every = [tmp_path / "in" / f"{number}.pcapng" for number in range(count)]
    for number, file in enumerate(every):
        make(file, began=BEGAN + number * DAY)
    add_here(tmp_path / "in", to=dataset)
    ledger = begin(store(str(dataset)))
    for entry in list(ledger.entries.values()):  # as if all had the same first 512 bytes
        alike = replace(entry, heads=("0" * 16,) * len(entry.heads))
        ledger.commit(alike)
    read: Counter[str] = Counter()
    original = growing.beginnings_of

    def counted(path: Path, lengths: Sequence[int]):
        read[path.name] += 1
        return original(path, lengths)

    monkeypatch.setattr(growing, "beginnings_of", counted)
    assert counts(add_here(tmp_path / "in", to=dataset)) == (0, 0, count, 0)
    assert read.total() <= count


def test_a_given_car_stays_when_the_recording_grows(tmp_path, whole) -> None:
    file, dataset = tmp_path / "drive.pcapng", tmp_path / "set"
    file.write_bytes(whole[: len(whole) // 2])
    other = make(tmp_path / "other.pcapng", began=BEGAN + 7200)
    add_here(file, to=dataset, settings=replace(SETTINGS, car="Служебная"))
    file.write_bytes(whole)
    seen: list = []
    made = planned(file, other, to=dataset)
    result = add(made, str(dataset), SETTINGS, HereRunner(), seen.append)
    assert counts(result) == (2, 1, 0, 0)
    assert len(seen) == 2
    asked = "SELECT car, known_by, rows FROM drives ORDER BY car"
    assert ask(dataset, asked) == [("A101MP52", "plate", ROWS), ("СЛУЖЕБНАЯ", "given", ROWS)]
    named = {name for it in open_ledger(store(str(dataset))).entries.values() for name in it.files}
    assert files_of(dataset) == named
    assert counts(add_here(file, other, to=dataset)) == (0, 0, 2, 0)
