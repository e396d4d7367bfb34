"""`mikas find` on a recording made by `log`: parameters, a flag, a derived channel."""

from __future__ import annotations

import numpy as np
import pytest

import mikas as library
from mikas.catalog import shipped
from mikas.errors import UsageError
from mikas.recording.search import SearchCondition, search

MADE: dict[str, bytes] = {}
"""The recording, once it was made: that takes a second."""


@pytest.fixture
def city(mikas, tmp_path):
    path = tmp_path / "a.pcapng"
    if not MADE:
        port = ("--port", "sim:?clock=simulated&scenario=city")
        names = ("FREQ", "RXX", "INJ")
        ran = mikas(*port, "log", "-o", path.name, *names, "--method", "batch", "--duration", "24")
        assert ran.status == 0
        MADE["city"] = path.read_bytes()
    path.write_bytes(MADE["city"])
    return path


def test_find_gives_all_moments_of_a_recording_and_their_peak(mikas, city):
    speed = np.concatenate([it.values["FREQ"] for it in library.open(city).rows()])
    found = search(library.open(city), SearchCondition(shipped(), "FREQ > 2000"))
    assert found.hits
    assert max(hit.peak for hit in found.hits) == np.nanmax(speed)
    assert sum(hit.rows for hit in found.hits) == np.count_nonzero(speed > 2000)
    ran = mikas("find", "a.pcapng", "freq > 2000", "--json")
    assert [(hit["from"], hit["to"], hit["peak"]) for hit in ran.object["hits"]] == [
        (hit.begin, hit.end, hit.peak) for hit in found.hits
    ]
    assert (ran.object["peak_of"], ran.object["from"]) == ("FREQ", found.begin)
    ran = mikas("find", "a.pcapng", "FREQ > 2000")
    assert len(ran.out.splitlines()) == 1 + len(found.hits)
    assert f"{len(found.hits)} moment" in ran.err
    flow = search(library.open(city), SearchCondition(shipped(), "FUEL_FLOW > 3")).hits
    assert flow
    assert all(hit.peak > 3 and hit.begin <= hit.peak_time <= hit.end for hit in flow)


def test_none_and_what_cannot_be_known_are_told_apart(mikas, city):
    ran = mikas("find", "a.pcapng", "FREQ > 9000", "--lang", "ru")
    assert (ran.status, ran.out) == (0, "")
    assert "ни в один момент" in ran.err
    with pytest.raises(UsageError, match="TAIR: not in this recording"):
        search(library.open(city), SearchCondition(shipped(), "TAIR > 10 and FREQ > 2000"))
    assert mikas("find", "a.pcapng", "FREQ >").status == 2


def test_damage_is_reported_and_the_rest_is_searched(mikas, city):
    data = bytearray(city.read_bytes())
    data[-3000:-2900] = bytes(100)
    city.write_bytes(data)
    ran = mikas("find", "a.pcapng", "FREQ > 2000")
    assert ran.status == 0
    assert "damaged" in ran.err
    assert ran.out
