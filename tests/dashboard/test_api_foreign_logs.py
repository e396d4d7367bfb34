"""Another program's log by the API: what it has, its values by the user's choice, its errors."""

from __future__ import annotations

import pytest

import mikas
from dashboard.recordings_rig import record
from dashboard.rig import ME, rig
from mikas.dashboard.api.library import foreign_logs
from mikas.dashboard.security import middleware

LAN = {"lan": True, "lan_control": True, "hosts": ("garage",), "token": "a-token-of-the-test"}
LOG = "t;Обороты (об/мин);Flag\n0;850,5;on\n40;;off\n80;900;on\n".encode("windows-1251")


@pytest.fixture(scope="module")
def desk(tmp_path_factory):
    with rig(tmp_path_factory.mktemp("desk"), None) as it:
        yield it


def ask(desk, part, content=LOG, status=200, headers=ME, **query):
    url = f"/api/foreign-logs/{part}"
    query = {"name": "лог.csv"} | query
    answer = desk.client.post(url, params=query, content=content, headers=headers)
    assert answer.status_code == status, answer.text
    return answer.json() if status == 200 else answer.json()["error"]


def test_a_log_is_shown_before_it_is_read(desk):
    found = ask(desk, "preview")
    assert found["format"] == "csv"
    assert found["columns"] == [
        {"name": "t", "unit": "", "samples": ["0", "40", "80"]},
        {"name": "Обороты", "unit": "об/мин", "samples": ["850,5", "", "900"]},
        {"name": "Flag", "unit": "", "samples": ["on", "off", "on"]},
    ]
    assert found["layout"] == {
        "encoding": "windows-1251", "delimiter": ";", "decimal": ",", "names_line": 1,
        "units_line": 0, "time": None, "time_unit": None,
    }  # fmt: skip
    other = ask(desk, "preview", encoding="windows-1252")["columns"]
    assert other[1]["name"].startswith("Îá")
    nameless = ask(desk, "preview", names_line=0)["columns"]
    assert [it["name"] for it in nameless] == ["№ 1", "№ 2", "№ 3"]
    error = ask(desk, "preview", delimiter=",", status=400)
    assert "another delimiter" in error["en"]


def test_the_values_are_those_that_were_chosen(desk):
    error = ask(desk, "values", status=400)
    assert (error["code"], "which column is the time" in error["en"]) == ("ForeignLogError", True)
    found = ask(desk, "values", time=0, time_unit="ms", columns="1,2")
    assert found["times"] == [0, 0.04, 0.08]
    assert found["names"] == ["Обороты", "Flag"]
    assert found["units"] == ["об/мин", ""]
    assert found["values"] == [[850.5, None, 900], [None, None, None]]
    assert (found["rows"], found["decimated"], found["started"]) == (3, False, None)
    assert "Flag" in found["problems"][0]["ru"]
    assert ask(desk, "values", time=0, time_unit="s", columns="1")["names"] == ["Обороты"]
    assert "3 columns" in ask(desk, "values", status=400, time=0, columns="7")["en"]
    ask(desk, "values", status=400, time=0, columns="1;2")
    ask(desk, "values", status=400, time=0, time_unit="fortnight")


def test_a_wrong_file_is_an_error_with_its_line(desk):
    error = ask(desk, "values", b"Time (s),x\n0,1\n1,2,3\n", 400)
    assert error["code"] == "ForeignLogError"
    assert "line 3" in error["en"]
    assert "строка 3" in error["ru"]
    assert "empty" in ask(desk, "preview", b"", 400)["en"]


def test_a_long_log_is_decimated_with_its_spikes(desk, monkeypatch):
    monkeypatch.setattr(foreign_logs, "_MOST_SENT", 100)
    monkeypatch.setattr(foreign_logs, "_LEAST_POINTS", 50)
    lines = ["Time (s),x", *(f"{at},{1000 if at == 777 else at % 3}" for at in range(2000))]
    found = ask(desk, "values", "\n".join(lines).encode())
    assert (found["rows"], found["decimated"]) == (2000, True)
    assert len(found["times"]) <= 60
    assert max(found["values"][0]) == 1000


def test_our_own_exports_come_back(desk, tmp_path):
    drive = mikas.open(record(tmp_path / "drive.pcapng"))
    for suffix in ("csv", "msl", "mlg"):
        out = tmp_path / f"drive.{suffix}"
        drive.export(out)
        found = ask(desk, "values", out.read_bytes(), name=out.name)
        assert found["format"] == suffix
        assert len(found["names"]) == len(drive.channels)
        assert found["rows"] == len(drive)


def test_a_file_that_is_too_large_is_refused(desk, monkeypatch):
    monkeypatch.setattr(middleware, "MOST_BYTES", 100)
    assert ask(desk, "preview", b"x" * 102, 413)["code"] == "TooLarge"


def test_only_this_computer_sends_one(tmp_path):
    with rig(tmp_path, None, **LAN) as it:
        headers = ME | {"Host": f"garage:{it.port}", "Authorization": f"Bearer {LAN['token']}"}
        for part in ("preview", "values"):
            assert ask(it, part, status=403, headers=headers)["code"] == "OnlyHere"
