"""A unit, a λ meter and a GPS on the page, by Chromium's own Web Serial: one of the two is pulled
out at random and plugged in again, and the unit never notices.

Each of the three sends other values in each message, and what it sent is written down here.
"""

from __future__ import annotations

import random
import re
import threading
from functools import reduce
from itertools import zip_longest
from operator import xor

import numpy as np
import pytest

import mikas
from mikas.catalog import shipped
from mikas.recording.capture.instruments import (
    CONNECTED,
    instrument_packets,
    label_and_name,
    loss_of,
)

from .computer_rig import CH340, Adapter
from .wire_rig import Wire

pytestmark = pytest.mark.realtime

CP2102 = Adapter("10c4", "ea60", "CP2102_USB_to_UART")
ALONE = 8.0  # s of the recording without instruments
_HELD_UP = 3  # times the usual time between two responses
UNPLUGS = 5
WITHIN = 3  # messages that are on their way when a cable is pulled out


class Instrument:
    """Sends another message each time, on a cable that can be pulled out. `sent`: the values;
    `pulled`: how many they were at each pull.
    """

    def __init__(self, computer, adapter, every):
        self._wire = Wire(computer, adapter)
        self._every, self._using, self._ended = every, threading.Lock(), threading.Event()
        self.sent, self.pulled = [], []
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def message(self, number):
        """The message of a number, and its value."""
        raise NotImplementedError  # each kind has its own

    def _run(self):
        while not self._ended.wait(self._every):
            with self._using:
                if self._wire.is_there:
                    message, value = self.message(len(self.sent))
                    self.sent.append(value)
                    self._wire.send(message)

    def pull(self):
        with self._using:
            self._wire.vanish()
            self.pulled.append(len(self.sent))

    def put_back(self):
        with self._using:
            self._wire.put_back()

    def close(self):
        self._ended.set()
        self._thread.join()
        self._wire.vanish()


class Meter(Instrument):
    def message(self, number):
        text = f"{10 + number / 100:.2f}"
        return text.encode() + b"\r\n", float(text)


class Receiver(Instrument):
    def message(self, number):
        knots = number / 10
        body = f"GPRMC,120000.00,A,5545.0000,N,03737.2000,E,{knots:.1f},90.0,011226,,,A".encode()
        return b"$%b*%02X\r\n" % (body, reduce(xor, body)), round(knots, 1)


@pytest.fixture
def sent_by_unit(car):
    """The speed is another one in each of the unit's responses: these, in rpm."""
    code, usual, sent = shipped().parameter("FREQ").code, car.car.raw, []

    def raw(asked, now):
        if asked != code:
            return usual(asked, now)
        step = 20 + len(sent) % 120
        sent.append(step * 40.0)
        return bytes([step])

    car.car.raw = raw
    yield sent
    car.car.raw = usual


@pytest.fixture
def instruments(whole_computer):
    made = {"aem": Meter(whole_computer, CH340, 0.1), "nmea": Receiver(whole_computer, CP2102, 0.3)}
    yield made
    for each in made.values():
        each.close()


def add(tab, name, port):
    tab.press("Add an instrument…")
    form = tab.find("dialog[open]")
    form.get_by_label("Instrument").select_option(name)
    form.get_by_label("Port").select_option(port)
    form.get_by_role("button", name="Add", exact=True).click()
    has_state(tab, name, "values")


def has_state(tab, name, state):
    tab.until(
        "async ([name, state]) => (await (await fetch('api/state')).json()).instruments"
        ".some(it => it.name === name && it.state === state)",
        [name, state],
    )


def recorded(tab, path):
    """End the recording, and take it out of the browser."""
    tab.stop_recording()
    name = tab.recordings()[0]["id"]
    tab.show("recordings").press(f"Export {name}")
    path.write_bytes(tab.download(tab.page.get_by_role("link", name=".pcapng", exact=True)))
    tab.page.keyboard.press("Escape")
    return path


def rate_and_lost(path, sent):
    """The unit's usual responses a second, and the share of those behind which one is not there
    though no time has passed for it.

    Each is found behind the one before. The rate is the one in the median, for a busy machine holds
    up a browser for a moment whatever is plugged in; what the unit sent meanwhile is not counted.
    """
    recording = mikas.open(path, names=["FREQ"])
    (rows,) = recording.rows()
    known = np.isfinite(rows.values["FREQ"])
    times, found = rows.times[known], rows.values["FREQ"][known]
    places, at = [], 0
    for value in found:
        at = sent.index(value, at) + 1
        places.append(at)
    seconds = np.diff(times)
    lost = (np.diff(places) > 1) & (seconds < _HELD_UP * np.median(seconds))
    return 1 / np.median(seconds), lost.mean()


def pieces(path, name):
    """The bytes of an instrument that followed one another, and why each piece ends: pulled out,
    or the page did not run for a while. The last one ends with the recording.
    """
    found, whys = [b""], []
    for packet in instrument_packets(path):
        if label_and_name(packet.source) != ("", name):
            continue
        if not packet.data and packet.comment == CONNECTED:
            found.append(b"")
        elif (loss := loss_of(packet)) is not None:
            whys.append(loss)
        elif packet.data:
            found[-1] += packet.data
    return list(zip_longest(found, whys))


def ends_alone(why):
    """Whether a busy machine held up the page, which leaves out what came meanwhile."""
    return why is not None and "did not run" in why.en


PATTERNS = {
    "aem": re.compile(rb"(?:^|\r\n)(\d\d\.\d\d)(?=\r\n)"),
    "nmea": re.compile(rb"(?:^|\r\n)\$GPRMC,120000.00,A,5545.0000,N,03737.2000,E,(\d+\.\d),"
                       rb"90.0,011226,,,A\*[0-9A-F]{2}(?=\r\n)"),
}  # fmt: skip


def test_one_pulled_out_at_random_costs_the_unit_nothing(tab, sent_by_unit, instruments, tmp_path):
    tab.show("live").record()
    tab.recorded(ALONE)
    rate, lost = rate_and_lost(recorded(tab, tmp_path / "alone.pcapng"), sent_by_unit)

    tab.show("connection")
    add(tab, "aem", "webserial:1a86:7523")
    add(tab, "nmea", "webserial:10c4:ea60")
    tab.show("live").record()
    chance = random.Random(5)
    for _ in range(UNPLUGS):
        name = chance.choice(list(instruments))
        tab.page.wait_for_timeout(1000 * chance.uniform(0.5, 2))
        instruments[name].pull()
        has_state(tab, name, "lost")
        tab.page.wait_for_timeout(1000 * chance.uniform(0.2, 2))
        instruments[name].put_back()
        has_state(tab, name, "values")
    ends = {name: [*each.pulled, len(each.sent)] for name, each in instruments.items()}
    path = recorded(tab, tmp_path / "beside.pcapng")
    assert all(each.pulled for each in instruments.values())

    beside, lost_beside = rate_and_lost(path, sent_by_unit)
    assert beside > 0.95 * rate
    assert lost_beside <= lost + 0.01
    for name, instrument in instruments.items():
        found, pulled_at, checked = pieces(path, name), iter(ends[name]), 0
        assert sum(not ends_alone(why) for _, why in found) == len(ends[name]), found
        for data, why in found:
            values = [float(it) for it in PATTERNS[name].findall(data)]
            end = 0 if ends_alone(why) else next(pulled_at)
            if not values:
                continue
            first = instrument.sent.index(values[0])
            last = first + len(values)
            assert values == instrument.sent[first:last]  # none is lost, none is the other's
            assert last >= end - WITHIN
            rest = PATTERNS[name].sub(b"", data)  # half a message at each end
            assert len(rest) < 2 * len(data) / len(values) + 4
            checked += len(values)
        assert checked > 30
    frame = mikas.open(path).to_pandas()
    assert set(frame["AFR"].dropna()) <= set(instruments["aem"].sent)
    knots = (frame["GPS_SPEED"].dropna() / 1.852).round(6)
    assert set(knots.round(1)) <= set(instruments["nmea"].sent)
    assert frame["AFR"].isna().any()
    assert frame["GPS_SPEED"].notna().any()
