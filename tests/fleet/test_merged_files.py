"""Files of several cars: each drive goes to its own, once."""

from __future__ import annotations

import gzip
from dataclasses import replace

from fleet_rig import SETTINGS, add_here, ask, counts, make
from merged_harness import needs_wireshark, ran
from mikas.fleet.ledger import open_ledger
from mikas.fleet.stores import store

ONE, TWO = "A111AA52", "B222BB52"
CARS = (
    "SELECT car, count(*), count(DISTINCT recording), min(plate) FROM drives GROUP BY 1 ORDER BY 1"
)


def cars(tmp_path):
    one = make(tmp_path / "one.pcapng", plate="А 111 АА 52")
    return one, make(tmp_path / "two.pcapng", plate="В 222 ВВ 52")


def test_each_drive_of_a_joined_file_goes_to_its_car(tmp_path):
    """Both drives were of the second car."""
    one, two = cars(tmp_path)
    path = tmp_path / "joined.pcapng"
    path.write_bytes(one.read_bytes() + two.read_bytes() + one.read_bytes())
    for expected in ((1, 0, 0, 0), (0, 0, 1, 0)):
        assert counts(add_here(path, to=tmp_path / "set")) == expected
        assert ask(tmp_path / "set", CARS) == [
            (ONE, 2, 1, "А 111 АА 52"),
            (TWO, 1, 1, "В 222 ВВ 52"),
        ]
    assert ask(tmp_path / "set", "SELECT count(DISTINCT drive) FROM samples") == [(3,)]
    (entry,) = open_ledger(store(str(tmp_path / "set"))).entries.values()
    assert (entry.car, entry.cars, entry.drives) == (None, (ONE, TWO), 3)


@needs_wireshark
def test_each_drive_of_a_merged_file_goes_to_its_car(tmp_path):
    one, two = cars(tmp_path)
    path = tmp_path / "merged.pcapng"
    ran("mergecap", "-I", "none", "-w", path, one, two)
    assert counts(add_here(path, to=tmp_path / "set")) == (1, 0, 0, 0)
    assert [row[:2] for row in ask(tmp_path / "set", CARS)] == [(ONE, 1), (TWO, 1)]
    alone = 'SELECT count(*), avg("FREQ") FROM samples'
    add_here(one, to=tmp_path / "alone")
    assert ask(tmp_path / "set", f"{alone} WHERE car = '{ONE}'") == ask(tmp_path / "alone", alone)


def test_a_given_car_for_a_file_of_several_is_refused(tmp_path):
    one, two = cars(tmp_path)
    path = tmp_path / "joined.pcapng"
    path.write_bytes(one.read_bytes() + two.read_bytes())
    result = add_here(path, to=tmp_path / "set", settings=replace(SETTINGS, car="mine"))
    assert counts(result) == (0, 0, 0, 1)
    assert "mikas split" in str(result.bad)


def test_a_packed_copy_is_the_same_recording(tmp_path):
    one, _ = cars(tmp_path)
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "one.pcapng.gz").write_bytes(gzip.compress(one.read_bytes()))
    assert counts(add_here(tmp_path / "in", to=tmp_path / "set")) == (1, 0, 0, 0)
    assert counts(add_here(one, tmp_path / "in", to=tmp_path / "set")) == (0, 0, 2, 0)
    assert [row[:2] for row in ask(tmp_path / "set", CARS)] == [(ONE, 1)]
