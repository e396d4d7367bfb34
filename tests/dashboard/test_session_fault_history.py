"""Confirmations and readings of the stored faults are bounded in number."""

from __future__ import annotations

from math import inf

import pytest

from mikas.catalog import shipped
from mikas.dashboard.errors import ConfirmationExpired
from mikas.dashboard.security.control import LIFETIME, Client, ConfirmationStore, PendingChange
from mikas.dashboard.session.history import FaultHistory
from mikas.i18n import Text

ME = Client("me", "Me", True)


async def nothing():
    return {}


def prepared(number):
    return PendingChange(Text("a change", "изменение"), number, None, nothing)


def test_of_very_many_confirmations_the_oldest_are_over():
    nonces = ConfirmationStore(lambda: 0.0)
    kept = [nonces.keep(ME, prepared(number)) for number in range(103)]
    for nonce in kept[:3]:
        with pytest.raises(ConfirmationExpired):
            nonces.use(ME, nonce)
    assert [nonces.use(ME, nonce).before for nonce in kept[3:]] == list(range(3, 103))


def test_a_confirmation_that_is_over_takes_no_place():
    now = [0.0]
    nonces = ConfirmationStore(lambda: now[0])
    for number in range(99):
        nonces.keep(ME, prepared(number))
    now[0] = LIFETIME / 2
    last = nonces.keep(ME, prepared(99))
    now[0] = LIFETIME
    kept = [nonces.keep(ME, prepared(number)) for number in range(99)]
    for nonce in (last, *kept):
        nonces.use(ME, nonce)


def test_of_very_many_readings_of_the_faults_the_latest_are_kept():
    history, faults = FaultHistory(), [shipped().fault(code) for code in (1, 2)]
    for time in range(250):
        history.add([faults[time % 2]], float(time))
    assert [reading.time for reading in history.readings] == [*map(float, range(150, 250)), 249.0]
    history.add([faults[1]], 260.0)  # the same again
    assert [reading.time for reading in history.readings][-2:] == [249.0, 260.0]


def test_a_fault_was_last_absent_at_the_reading_before_it_came():
    history, fault = FaultHistory(), shipped().fault(13)
    history.add([fault], 1.0)
    assert history.absent_at(13) == -inf
    history.add([], 2.0)
    history.add([fault], 3.0)
    assert history.absent_at(13) == 2.0
    history.add([], 4.0)
    history.add([fault], 5.0, erased=True)  # and came back at once
    assert history.absent_at(13) == 5.0
