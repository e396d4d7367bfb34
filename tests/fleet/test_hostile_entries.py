"""Entries of a stranger that would replace the recordings of others: none of those is lost."""

from __future__ import annotations

import json
from contextlib import suppress
from pathlib import Path

import pytest

from fleet_rig import BEGAN, DAY, SETTINGS, add_here, ask, counts, files_of, make, make_dataset
from mikas.cli.main import run
from mikas.fleet.entries import FOLDER, LedgerEntry
from mikas.fleet.ledger import MARKER, open_ledger
from mikas.fleet.stores import store

KEY = "deadbeef" * 4
OTHER = "abad1dea" * 4
COUNT = "SELECT count(*) FROM drives"


@pytest.fixture
def home(tmp_path) -> Path:
    """A dataset of three recordings."""
    (tmp_path / "nothing").mkdir()
    drives = {f"{number}.pcapng": {"began": BEGAN + number * DAY} for number in range(3)}
    return make_dataset(tmp_path, drives)


def entries_of(home: Path) -> list[LedgerEntry]:
    return list(open_ledger(store(str(home))).entries.values())


def plant(home: Path, key: str = KEY, **parts: object) -> Path:
    """Write an entry as a stranger may: of a recording of 8 KB, whose tables are not there."""
    value = {
        "key": key, "sha256": key * 2, "bytes": 8192, "heads": ["0" * 16] * 8, "version": "1",
    }  # fmt: skip
    path = home / FOLDER / f"{key}.json"
    path.write_text(json.dumps(value | parts))
    return path


def all_count(home: Path, *refused: Path) -> None:
    """All three count, also after `add`, and the hostile entries are named."""
    files = files_of(home)
    for _ in range(2):
        ledger = open_ledger(store(str(home)))
        assert len(ledger.entries) == 3
        assert set(ledger.refused) == {f"{FOLDER}/{it.name}" for it in refused}
        assert all(reason.ru for reason in ledger.refused.values())
        assert ask(home, COUNT) == [(3,)]
        result = add_here(home.parent / "nothing", to=home)
        assert {Path(bad.file).name for bad in result.bad} == {it.name for it in refused}
    assert files_of(home) == files


def parts_of_all(home: Path) -> dict[str, dict]:
    """What a hostile entry may say of the others."""
    every = entries_of(home)
    tables = [name for it in every for name in it.files]
    names = [it.name for it in every]
    keys = [it.key for it in every]
    sources = {place: "1-1" for it in every for place in it.sources}
    heads = list(every[0].heads)
    return {
        "all": {"obsolete": tables + names, "replaces": keys},
        "tables": {"obsolete": tables},
        "one table": {"obsolete": tables[:1]},
        "entries": {"obsolete": names},
        "replaces": {"replaces": keys},
        "one of them": {"replaces": keys[:1]},
        "places": {"obsolete": tables + names, "replaces": keys, "sources": sources},
        "no heads": {"obsolete": names, "sources": sources, "bytes": 0, "heads": []},
        "one head": {"obsolete": names, "sources": sources, "bytes": 600, "heads": ["0" * 16]},
        "longest": {"replaces": keys, "bytes": (1 << 63) - 1},
        "heads of one": {"replaces": keys, "heads": heads, "bytes": 1 << 40},
        "shorter": {"replaces": [every[0].key], "heads": heads, "bytes": 4096},
        "as long": {"replaces": [every[0].key], "heads": heads, "bytes": every[0].bytes},
        "elsewhere": {"obsolete": [every[0].name], "heads": heads, "bytes": 4096},
    }


KINDS = (
    "all", "tables", "one table", "entries", "replaces", "one of them", "places", "no heads",
    "one head", "longest", "heads of one", "shorter", "as long", "elsewhere",
)  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_an_entry_replaces_no_other_recording(home, kind) -> None:
    """All others vanished without a word, and `add` removed their tables."""
    all_count(home, plant(home, **parts_of_all(home)[kind]))


def test_what_is_refused_is_said_by_sql_and_by_add(home, capsys) -> None:
    entry = plant(home, **parts_of_all(home)["all"])
    assert run(["fleet", "sql", str(home), COUNT]) == 0
    out = capsys.readouterr()
    assert out.out.split() == ["count_star()", "3"]
    assert entry.name in out.err
    assert "replaces" in out.err
    add = ["fleet", "add", str(home.parent / "nothing"), "--to", str(home), "--workers", "1"]
    assert run(add) != 0
    assert entry.name in capsys.readouterr().err


@pytest.mark.parametrize(
    "name",
    [
        MARKER, f"{FOLDER}", f"{FOLDER}/", f"{FOLDER}/../{MARKER}", f"./{MARKER}", "../in/0.pcapng",
        f"samples/car=..\\..\\..\\in/day=x/{KEY}-00000000.parquet",
        f"samples/car=x/day=..\\..\\../{KEY}-00000000.parquet",
        f"samples/car=x/day=../../{KEY}-00000000.parquet",
        f"samples/../{FOLDER}/car=x/day=y/{KEY}-00000000.parquet",
        f"{FOLDER}/{KEY}.json",
    ],
)  # fmt: skip
def test_an_obsolete_name_of_another_kind_is_refused(home, name) -> None:
    all_count(home, plant(home, obsolete=[name]))
    assert (home / MARKER).is_file()


def test_an_entry_that_makes_its_own_table_obsolete_is_refused(home) -> None:
    table = f"drives/car=_unknown/day=2026-03-02/{KEY}-00000000.parquet"
    all_count(home, plant(home, files=[table], obsolete=[table]))


@pytest.mark.parametrize("kind", ["long", "link", "folder", "gone"])
@pytest.mark.posix
def test_an_own_obsolete_table_that_cannot_be_removed_stops_nothing(home, tmp_path, kind) -> None:
    name = f"drives/car={'x' * (300 if kind == 'long' else 3)}/day=y/{KEY}-00000000.parquet"
    (tmp_path / "outside" / "day=y").mkdir(parents=True)
    canary = tmp_path / "outside" / "day=y" / f"{KEY}-00000000.parquet"
    canary.write_bytes(b"keep")
    if kind == "link":
        (home / "drives" / "car=xxx").symlink_to(tmp_path / "outside")
    elif kind == "folder":
        (home / name).mkdir(parents=True)
    plant(home, obsolete=[name])
    result = add_here(tmp_path / "nothing", to=home)
    assert counts(result) == (0, 0, 0, 0)
    assert ask(home, COUNT) == [(3,)]
    assert canary.read_bytes() == b"keep"


def test_two_hostile_entries_that_replace_each_other_hide_only_themselves(home) -> None:
    every = entries_of(home)
    keys = [it.key for it in every]
    one = plant(home, replaces=[OTHER, *keys], bytes=9000)
    other = plant(home, OTHER, obsolete=[f"{FOLDER}/{KEY}.json"], replaces=keys)
    all_count(home, one, other)
    same = {"sources": {"/a": "1-1"}}
    plant(home, obsolete=[f"{FOLDER}/{OTHER}.json"], **same)
    plant(home, OTHER, obsolete=[f"{FOLDER}/{KEY}.json"], **same)
    assert {it.key for it in entries_of(home)} - {KEY, OTHER} == set(keys)
    assert len(entries_of(home)) == 4
    add_here(home.parent / "nothing", to=home)
    assert ask(home, COUNT) == [(3,)]


def test_a_chain_of_hostile_entries_hides_no_other(home) -> None:
    keys = [it.key for it in entries_of(home)]
    chain = [f"{number:032x}" for number in range(1, 4)]
    last = plant(home, chain[0], bytes=8000, replaces=keys)
    for number, key in enumerate(chain[1:], 1):
        plant(home, key, bytes=8000 + number, replaces=chain[:number])
    assert set(keys) < {it.key for it in entries_of(home)}
    assert last.exists()
    add_here(home.parent / "nothing", to=home)
    assert ask(home, COUNT) == [(3,)]


def test_an_entry_with_the_copied_heads_of_a_recording_hides_that_one_alone(home) -> None:
    """What remains possible, as security.md says."""
    victim, *others = entries_of(home)
    gone = [victim.name, *victim.files]
    plant(home, heads=victim.heads, bytes=1 << 40, obsolete=gone, replaces=[victim.key])
    assert ask(home, COUNT) == [(2,)]
    add_here(home.parent / "nothing", to=home)
    assert files_of(home) == {name for it in others for name in it.files}


def test_a_recording_whose_entry_was_refused_counts_when_it_is_added_again(home, tmp_path) -> None:
    """A stranger has its entry replace another one."""
    one, other, _ = entries_of(home)
    path = home / one.name
    path.write_text(json.dumps(json.loads(path.read_bytes()) | {"replaces": [other.key]}))
    assert ask(home, COUNT) == [(2,)]
    for file in [*(tmp_path / "in").iterdir()]:
        (tmp_path / "in" / f"copy of {file.name}").write_bytes(file.read_bytes())
    result = add_here(tmp_path / "in", to=home)
    assert (result.added, result.skipped) == (1, 5)
    assert ask(home, COUNT) == [(3,)]
    assert counts(add_here(tmp_path / "in", to=home)) == (0, 0, 6, 0)


def test_a_claim_to_replace_a_recording_does_not_keep_it_from_being_added(home, tmp_path) -> None:
    """The stranger knew its digest, and nothing of its content."""
    later = make(tmp_path / "later" / "x.pcapng", began=BEGAN + 9 * DAY)
    add_here(later, to=tmp_path / "other")
    (entry,) = entries_of(tmp_path / "other")
    hostile = plant(home, replaces=[entry.key])
    assert counts(add_here(later, to=home))[:3] == (1, 0, 0)
    assert ask(home, COUNT) == [(4,)]
    assert f"{FOLDER}/{hostile.name}" in open_ledger(store(str(home))).refused


def test_a_true_beginning_with_false_heads_does_not_make_the_whole_refused(home, tmp_path) -> None:
    """The entry of the whole names what it replaces, and that has to be proven by both."""
    whole = make(tmp_path / "grown" / "x.pcapng", began=BEGAN + 9 * DAY)
    data = whole.read_bytes()
    whole.write_bytes(data[: len(data) // 2])
    add_here(whole, to=home)
    (part,) = (it for it in entries_of(home) if it.bytes == len(data) // 2)
    path = home / part.name
    path.write_text(json.dumps(json.loads(path.read_bytes()) | {"heads": ["0" * 16] * 8}))
    whole.write_bytes(data)
    add_here(whole, to=home)
    assert open_ledger(store(str(home))).refused == {}
    assert ask(home, "SELECT count(*) FROM drives WHERE rows = 239") == [(4,)]


@pytest.mark.parametrize("removed", range(8))
def test_an_interrupted_removal_is_ended_by_the_next_program(
    tmp_path, removed, monkeypatch
) -> None:
    """However many files of the earlier state were removed already."""
    file, dataset = tmp_path / "a.pcapng", tmp_path / "set"
    whole = make(file).read_bytes()
    file.write_bytes(whole[: len(whole) // 2])
    add_here(file, to=dataset)
    file.write_bytes(whole)
    target = type(store(str(dataset)))
    remove, left = target.remove, [removed]

    def killed(self, name: str) -> None:
        if name.endswith((".parquet", ".json")):
            if not left[0]:
                raise KeyboardInterrupt
            left[0] -= 1
        remove(self, name)

    monkeypatch.setattr(target, "remove", killed)
    with suppress(KeyboardInterrupt):
        add_here(file, to=dataset)
    monkeypatch.undo()
    assert ask(dataset, "SELECT count(*), sum(rows) FROM drives") == [(1, 239)]
    assert counts(add_here(file, to=dataset)) == (0, 0, 1, 0)
    ((entry,), refused) = entries_of(dataset), open_ledger(store(str(dataset))).refused
    assert files_of(dataset) == set(entry.files)
    assert (entry.obsolete, refused) == ((), {})
    assert len(list((dataset / FOLDER).iterdir())) == 1
    assert entry.is_current(SETTINGS.version, "")
