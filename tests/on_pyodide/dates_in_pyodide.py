"""The browser's date is compared with its clock: `Date.now` with `performance.now`."""

from __future__ import annotations

import pytest
from pyodide.code import run_js

from mikas.link.clocks import WallClock
from mikas.link.reconnecting import ReconnectingPort
from mikas.sampling.date_watch import DateWatch

NIGHT = 43_200.0


@pytest.fixture
def jump():
    """A function by which the browser's date jumps; its clock stands meanwhile."""
    real = run_js("Date.now")
    yield lambda seconds: run_js("(now, ms) => { Date.now = () => now() + ms }")(
        real, seconds * 1000
    )
    run_js("(now) => { Date.now = now }")(real)


@pytest.mark.parametrize("broken", [True, False])
def test_a_jump_of_the_browsers_date_is_seen_and_a_sleep_is_added(jump, broken):
    port, watch = ReconnectingPort("sim:", wall=WallClock()), DateWatch()
    began = port.now()
    assert watch.look(*port.dated(), broken=broken) is None
    jump(-NIGHT if not broken else NIGHT)
    found = watch.look(*port.dated(), broken=broken) or watch.conclude()
    assert found is not None
    assert abs(found.seconds) == pytest.approx(NIGHT, abs=0.1)
    assert found.slept is broken
    if found.slept:
        port.slept(found.seconds)
        assert port.now() > began + NIGHT - 1
    assert watch.look(*port.dated(), broken=broken) is None
