"""Another program's log read in a process of its own: what comes back, and what can't harm."""

from __future__ import annotations

import os

import numpy as np
import pytest

from mikas.cancellation import Cancellation, Cancelled
from mikas.errors import ForeignLogError
from mikas.foreign_logs import LogChoice, apart, preview_log, read_log
from mikas.foreign_logs.apart import preview_apart, read_apart

CSV = b"Time (s),RPM\n0,800\n1,801\n"


@pytest.fixture
def mdf(tmp_path) -> bytes:
    asammdf = pytest.importorskip("asammdf", reason="MDF4 needs the extra mdf")
    file = asammdf.MDF(version="4.10")
    times = np.array([0.0, 0.5, 1.0])
    file.append([asammdf.Signal(np.array([1.0, 2.0, 3.0]), times, name="Oil", unit="bar")])
    data = file.save(tmp_path / "a.mf4").read_bytes()
    file.close()
    return data


def breaks_down(data: bytes, name: str, settings: object) -> None:
    """As asammdf does at some damaged files, whose compiled code reads outside its memory."""
    os._exit(139)


def never_ends(data: bytes, name: str, settings: object) -> None:
    while True:
        pass


def test_it_is_the_same_as_in_place(mdf):
    assert preview_apart(mdf, "a.mf4") == preview_log(mdf, "a.mf4")
    choice = LogChoice(columns={"Oil": None})
    assert read_apart(mdf, "a.mf4", choice) == read_log(mdf, "a.mf4", choice)
    assert read_apart(CSV, "a.csv") == read_log(CSV, "a.csv")
    assert preview_apart(CSV, "a.csv") == preview_log(CSV, "a.csv")


def test_its_errors_are_those_of_the_file(mdf):
    with pytest.raises(ForeignLogError) as caught:
        read_apart(mdf[: len(mdf) // 2], "a.mf4")
    assert caught.value.text.en.startswith("a.mf4: can't be read as MDF4")
    with pytest.raises(ForeignLogError, match="no column “Fuel”"):
        read_apart(mdf, "a.mf4", LogChoice(columns={"Fuel": None}))


def test_an_error_of_the_library_is_words_for_a_person(mdf, capfd):
    """No place in memory, and no traceback of what the library leaves behind."""
    with pytest.raises(ForeignLogError, match="as MDF4") as caught:
        read_apart(mdf[:88] + b"\xff" * 400 + mdf[488:], "a.mf4")
    assert "0x" not in str(caught.value)
    assert capfd.readouterr().err == ""


def test_a_reading_that_breaks_down_ends_its_own_process_only(mdf):
    with pytest.raises(ForeignLogError, match="its reading broke down: copy it again"):
        apart.in_own_process(breaks_down, mdf, "a.mf4", None)


def test_a_reading_that_never_ends_is_ended(mdf, monkeypatch):
    monkeypatch.setattr(apart, "LONGEST", 0.3)
    with pytest.raises(ForeignLogError, match="save a part of the log"):
        apart.in_own_process(never_ends, mdf, "a.mf4", None)


def test_a_client_that_has_gone_ends_the_reading(mdf):
    gone = Cancellation()

    def work() -> None:
        gone.request()
        apart.in_own_process(never_ends, mdf, "a.mf4", None)

    with pytest.raises(Cancelled):
        gone.run(work)
