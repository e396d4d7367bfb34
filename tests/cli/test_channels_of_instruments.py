"""An instrument's channel among the names of a command: with the instrument, and without it."""

from __future__ import annotations

from pathlib import Path

import pytest
from cli_harness import Mikas


@pytest.mark.parametrize(
    ("name", "example"),
    [("AFR", "aem=/dev/ttyUSB1"), ("afr_left/10", "aem=/dev"), ("GPS_SPEED", "nmea=/dev/ttyUSB1")],
)
def test_without_an_instrument_the_error_says_how_to_give_one(
    mikas: Mikas, name: str, example: str
) -> None:
    for command in (["watch"], ["log", "-o", "a.pcapng"]):
        done = mikas(*command, "FREQ", name, "--count", "1")
        assert done.status == 2
        assert "It is a channel of an instrument beside the unit" in done.err
        assert f"--instrument NAME=URL, as {example}" in done.err
    mikas.speaks("ru")
    assert "Это канал прибора рядом с блоком" in mikas("watch", "FREQ", name).err


def test_another_instrument_does_not_give_it(mikas: Mikas) -> None:
    done = mikas("watch", "FREQ", "AFR", "--count", "1", "--instrument", "nmea=sim:")
    assert done.status == 2
    assert "as aem=/dev/ttyUSB1" in done.err


@pytest.mark.parametrize("name", ["AFR", "afr/10", "LAMBDA"])
def test_with_its_instrument_it_may_be_named(mikas: Mikas, tmp_path: Path, name: str) -> None:
    (tmp_path / "rules.toml").write_text(
        '[action.a]\nwhen = "TWAT > 200"\n[action.a.mark]\nen = "hot"\nru = "горячо"\n', "utf-8"
    )
    done = mikas("watch", "FREQ", name, "--count", "2", "--instrument", "aem=sim:")
    assert (done.status, done.lines[0].split("\t")[1:4]) == (0, ["FREQ", "LAMBDA", "AFR"])
    done = mikas(
        "watch", "FREQ", name, "--count", "2", "--instrument", "aem=sim:",
        "--actions", "rules.toml",
    )  # fmt: skip
    assert (done.status, done.lines[0].split("\t")[1:3]) == (0, ["FREQ", "TWAT"])


def test_alone_it_stands_for_no_parameter_of_the_unit(mikas: Mikas) -> None:
    done = mikas("watch", "AFR", "--instrument", "aem=sim:")
    assert done.status == 2
    assert "name a parameter of the unit as well" in done.err


def test_a_search_for_it_says_that_an_instrument_was_missing(mikas: Mikas) -> None:
    mikas("log", "-o", "a.pcapng", "FREQ", "--count", "3")
    done = mikas("find", "a.pcapng", "AFR > 15")
    assert "AFR: not in this recording" in done.err
    assert "a channel of an instrument needs one beside the unit" in done.err
    assert "instrument" not in mikas("find", "a.pcapng", "TWAT > 15").err
