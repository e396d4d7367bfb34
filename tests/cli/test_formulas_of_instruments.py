"""Formulas of instruments on the command line: actions, `find`, derived columns."""

from __future__ import annotations

from pathlib import Path

import pytest
from cli_harness import Mikas

import mikas as library
from mikas.sampling.events import Marker

ACTIONS = """
[action.burns]
when = "LAMBDA > 0.5 and FREQ > 100"
for = 1
mark = { en = "λ {LAMBDA} at {FREQ}", ru = "λ {LAMBDA} при {FREQ}" }
"""


@pytest.fixture
def actions(tmp_path: Path) -> tuple[str, str]:
    (tmp_path / "actions.toml").write_text(ACTIONS, encoding="utf-8")
    return ("--actions", "actions.toml")


def test_an_action_fires_on_a_meter_and_find_has_the_same_moments(
    mikas: Mikas, tmp_path: Path, actions: tuple[str, str]
) -> None:
    done = mikas(
        "log", "-o", "a.pcapng", "TWAT", "--rate", "5", "--duration", "8", *actions,
        "--instrument", "aem=sim:", sim="&scenario=city",
    )  # fmt: skip
    assert done.status == 0
    assert "◆ burns: LAMBDA > 0.5 and FREQ > 100, for 1." in done.err
    recording = library.open(tmp_path / "a.pcapng")
    (marker,) = [event for event in recording.events if isinstance(event, Marker)]
    assert marker.label.startswith("λ ")
    assert "at 8" in marker.label
    found = mikas("find", "a.pcapng", "LAMBDA > 0.5 and FREQ > 100", "--json")
    (hit,) = found.object["hits"]
    assert (found.object["peak_of"], hit["rows"] > 10) == ("LAMBDA", True)
    assert 0.5 < hit["peak"] < 2
    assert hit["from"] <= marker.time <= hit["to"]
    done = mikas("find", "a.pcapng", "GPS_SPEED > 5")
    assert done.status == 2
    assert "GPS_SPEED: not in this recording" in done.err
    done = mikas("find", "a.pcapng", "LAMBDDA > 5")
    assert done.status == 2
    assert "Did you mean LAMBDA" in done.err


def test_an_action_without_its_instrument_is_refused_before_the_port(
    mikas: Mikas, tmp_path: Path, actions: tuple[str, str]
) -> None:
    for command in (("watch", "FREQ"), ("log", "-o", "a.pcapng", "FREQ")):
        done = mikas(*command, *actions)
        assert done.status == 2
        assert "needs LAMBDA, which no instrument of this run gives" in done.err
        assert not (tmp_path / "a.pcapng").exists()
    mikas.speaks("ru")
    assert "нужен LAMBDA" in mikas("watch", "FREQ", *actions).err
    done = mikas("watch", "FREQ", *actions, "--instrument", "left:aem=sim:")
    assert done.status == 2  # the meter has another name here
