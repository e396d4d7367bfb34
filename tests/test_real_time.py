"""The site's ports: a clock that never waits is refused."""

from __future__ import annotations

import pytest

from mikas.browser.real_time import open_in_real_time
from mikas.dashboard.settings import VirtualCars
from mikas.errors import BadPortUrl


@pytest.mark.parametrize("url", ["sim:?clock=simulated", "replay:a.pcapng?loop=1&clock=simulated"])
def test_a_simulated_clock_is_refused_with_what_to_leave_out(url):
    with pytest.raises(BadPortUrl, match="leave it out"):
        VirtualCars(open_in_real_time).open(url)


def test_a_car_in_real_time_is_opened():
    with VirtualCars(open_in_real_time).open("sim:?clock=real&scenario=warm-idle") as link:
        assert link.is_virtual
