"""A pedal that holds one speed: the throttle neither fails to close nor meets a stop."""

from __future__ import annotations

from functools import cache

import pytest

from mikas.catalog import shipped
from mikas.catalog.loading.source import parse_source
from mikas.causes.features import View, features_of
from mikas.causes.ranking import rank
from mikas.causes.regimes import Regime, drive_of
from mikas.causes.result import CauseVerdict
from mikas.causes.rows import CHANNELS
from mikas.causes.samples import Samples, samples_of
from mikas.virtual.cars import EngineCar
from mikas.virtual.defects.car import WornCar
from mikas.virtual.model.engine import Engine
from mikas.virtual.scenarios.scenario import from_source

WARM = "ambient = 12\ncoolant = 85\nrunning = true"
STEADY = {
    "one speed": "[[0, 60], [300, 60]]",
    "two speeds": "[[0, 60], [150, 60], [160, 90], [300, 90]]",
    "a fast road": "[[0, 90], [300, 90]]",
    "never held quite": "[[0, 70], [60, 74], [120, 69], [180, 75], [240, 70], [300, 73]]",
}


@cache
def _driven(speed: str, start: str = WARM, stop: float = 0.0) -> Samples:
    """Return the samples of a drive. `stop`: the least opening of its throttle, %."""
    text = f"duration = 300\n[start]\n{start}\n[timeline]\nkey = [[0, 1]]\nspeed = {speed}\n"
    car = WornCar({"throttle_stops": (stop, 100.0)} if stop else {})
    scenario = car.applied_to(from_source(parse_source("car.toml", text.encode())))
    unit = EngineCar(Engine(scenario, 1), shipped())
    times = [0.3 + 0.25 * row for row in range(1180)]
    rows = [
        [float(shipped().parameter(name).decode(unit.raw(code, time))) for name, code in _codes()]
        for time in times
    ]
    return samples_of(times, dict(zip(CHANNELS, zip(*rows, strict=True), strict=True)))


def _codes() -> list[tuple[str, int]]:
    return [(name, shipped().parameter(name).code) for name in CHANNELS]


@pytest.mark.parametrize("name", STEADY)
def test_a_sound_car_that_holds_its_speed_is_not_accused(name: str) -> None:
    samples = _driven(STEADY[name])
    ranking = rank([samples])
    assert ranking.verdict in (CauseVerdict.SOUND, CauseVerdict.CANNOT_TELL)
    assert "throttle_stops" not in [cause.id for cause in ranking.causes]
    drive = drive_of(samples)
    assert drive is not None
    assert not drive.let_go
    assert not drive.rows[Regime.WARM_IDLE]
    assert not {"least-throttle", "widest-throttle", "flat-top"} & set(features_of(drive))


def test_a_throttle_that_does_not_close_is_seen_where_the_foot_is_off() -> None:
    for speed in ("[[0, 0], [300, 0]]", "[[0, 60], [60, 60], [75, 0], [300, 0]]"):
        samples = _driven(speed, stop=3.0)
        drive = drive_of(samples)
        assert drive is not None
        assert (drive.let_go, drive.closed) == (True, 3.0)
        assert rank([samples]).causes[0].id == "throttle_stops"


def test_an_engine_whose_key_was_taken_has_not_stalled() -> None:
    """The unit is silent without its key; an engine that dies is seen to the last turn."""
    for silent, stalls in ((0.0, 1), (12.0, 0)):
        times = [number * 0.5 for number in range(100)]
        times += [times[-1] + 0.5 + silent + number * 0.5 for number in range(20)]
        speed = [850.0] * 100 + [0.0] * 20
        drive = drive_of(samples_of(times, {"FREQ": speed, "FREQX": speed}))
        assert drive is not None
        assert len(drive.stalls) == stalls
        assert View(drive).column("FREQ") == speed
