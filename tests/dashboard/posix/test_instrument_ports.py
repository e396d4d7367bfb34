"""An instrument at a serial port of its own: a meter behind a pty, which fails and comes back."""

from __future__ import annotations

import os
import pty
import tty

import pytest

from dashboard.rig import rig
from mikas.link import open_link

# As "aem", but a value holds for ten seconds of the car's time, which runs twenty times as fast as
# the pty's: a second of it is over before the next live message.
LASTING = {
    "text": {"en": "AEM wide-band gauge", "ru": "Широкополосный прибор AEM"},
    "baud": 9600,
    "patterns": ["{LAMBDA}"],
    "stale": 10,
    "channels": [],
}


class Meter:
    """A λ meter at a pty, whose name stays when it is unplugged."""

    def __init__(self, folder):
        self._name = folder / "ttyMeter"
        self.port = str(self._name)
        self.plug()

    def plug(self):
        self._own, other = pty.openpty()
        tty.setraw(other)
        self._name.symlink_to(os.ttyname(other))
        os.close(other)

    def unplug(self):
        self._name.unlink()
        os.close(self._own)

    def send(self, text):
        os.write(self._own, text)


@pytest.fixture
def meter(tmp_path):
    return Meter(tmp_path)


@pytest.fixture
def car(tmp_path, meter):
    with rig(tmp_path, "sim:?scenario=warm-idle") as it:
        cars = it.dashboard.settings.open_port
        it.opened = []

        def open_port(url):
            if not url.startswith(meter.port):
                return cars(url)
            it.opened.append(url)
            return open_link(url)

        object.__setattr__(it.dashboard.settings, "open_port", open_port)
        it.sampling()
        yield it


def state_of(message):
    (found,) = message["state"]["instruments"]
    return found


def until_state(car, meter, state, line=b""):
    """Send `line` with each live message until the instrument has that state."""
    with car.live() as live:
        for _ in range(600):
            if line:
                meter.send(line)
            message = live.next()
            message["state"] = live.state
            if state_of(message)["state"] == state:
                return message
    raise AssertionError(f"never {state}: {state_of(message)}")


def test_values_damage_a_loss_and_its_end(car, meter):
    car.put("/instruments/definitions/lasting", LASTING)
    car.post("/instruments", {"definition": "lasting", "port": meter.port})
    until_state(car, meter, "values", b"1.02\r\n")
    assert car.opened == [f"{meter.port}?baud=9600"]
    assert car.get("/channels/LAMBDA/value")["value"] == pytest.approx(1.02)

    found = state_of(until_state(car, meter, "silent", b"?!\r\n"))
    assert "not understood" in found["text"]["en"]
    assert found["damaged"] > 0

    meter.unplug()
    found = state_of(until_state(car, meter, "lost"))
    assert "the unit is read on" in found["text"]["en"]
    assert car.sampling()["rate"] > 0

    meter.plug()
    until_state(car, meter, "values", b"0.98\r\n")
    assert car.get("/state")["errors"] == 0
