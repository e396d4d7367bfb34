"""The search through the API: in a recording, in the live values, and the kept conditions."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import mikas
from dashboard.recordings_rig import record
from dashboard.rig import rig


@pytest.fixture(scope="module")
def desk(tmp_path_factory):
    folder = tmp_path_factory.mktemp("search")
    (folder / "recordings").mkdir()
    record(folder / "recordings" / "drive.pcapng", count=60)
    with rig(folder, None) as it:
        it.folder = folder
        yield it


def find(desk, path: str, expression: str, status: int = 200):
    return desk.get(path, status, expression=expression)


def test_a_condition_finds_all_moments_of_a_recording(desk) -> None:
    path = desk.folder / "recordings" / "drive.pcapng"
    speed = np.concatenate([rows.values["FREQ"] for rows in mikas.open(path).rows()])
    least = np.nanmin(speed)
    found = find(desk, "/recordings/drive.pcapng/find", f"FREQ >= {least}")
    assert found["count"] == len(found["hits"]) > 0
    assert (found["peak_of"], found["lowest"]) == ("FREQ", False)
    assert max(hit["peak"] for hit in found["hits"]) == np.nanmax(speed)
    assert sum(hit["rows"] for hit in found["hits"]) == np.count_nonzero(speed >= least)
    assert found["begin"] <= found["hits"][0]["begin"] <= found["hits"][-1]["end"] <= found["end"]
    assert find(desk, "/recordings/drive.pcapng/find", f"FREQ < {least}")["hits"] == []
    wrong = find(desk, "/recordings/drive.pcapng/find", "FREK > 900", 400)
    assert "FREQ" in wrong["en"]
    assert find(desk, "/recordings/no.pcapng/find", "FREQ > 1", 404)["code"] == "NotFound"


def test_a_condition_finds_moments_of_the_live_values(desk) -> None:
    nothing = find(desk, "/history/find", "TWAT > 100")
    assert nothing == {
        "hits": [], "count": 0, "peak_of": "TWAT", "lowest": False, "begin": None, "end": None,
    }  # fmt: skip
    history = desk.dashboard.history
    for at, coolant in enumerate([99, 101, 104, np.nan, 102, 98, 101]):
        history.add(1000.0000004 + at * 0.5, ("TWAT", "DET"), (coolant, 1.0))
    found = find(desk, "/history/find", "TWAT > 100 and DET")
    assert [(it["begin"], it["end"], it["peak"], it["peak_time"]) for it in found["hits"]] == [
        (1000.5, 1002.0, 104, 1001.0),
        (1003.0, 1003.0, 101, 1003.0),
    ]
    assert [hit["rows"] for hit in found["hits"]] == [4, 1]  # a value holds for a second


def test_conditions_are_kept(desk) -> None:
    kept = [{"name": "перегрев", "expression": "TWAT > 100"}]
    with ThreadPoolExecutor(4) as pool:  # several pages at once
        put = [pool.submit(desk.put, "/searches", {"searches": kept}) for _ in range(16)]
    assert all(each.result() == {"searches": kept} for each in put)
    assert desk.get("/searches") == {"searches": kept}
    wrong = {"searches": [{"expression": "TWAT >"}]}
    assert desk.put("/searches", wrong, 400)["code"] == "UsageError"
    assert desk.get("/searches") == {"searches": kept}
