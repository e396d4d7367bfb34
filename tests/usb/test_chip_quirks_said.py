"""What `ports` and `doctor` say of a chip (`mikas.link.chips`) is what its model does."""

from __future__ import annotations

import pytest

from mikas.link.chips import chip_of, has_latency_timer, has_usual_rates
from usb.book_rig import Far, opened
from usb.chips.cp210x import LISTED
from usb.chips.named import NAMES, driver_of, plugged
from usb.chips.uart import Settings

BOARDS = {"CDC ACM", "CDC ACM without break"}
TENS = 10400


@pytest.fixture(params=NAMES)
def model(request):
    return request.param, plugged(request.param, Far())


def said(device):
    return chip_of(device.identity.vid, device.identity.pid)


def test_every_chip_has_a_name_and_a_board_has_none(model):
    name, device = model
    assert bool(said(device)[0]) == (name not in BOARDS)


def test_a_latency_timer_is_an_ftdis_alone(model):
    name, device = model
    assert has_latency_timer(said(device)[0]) == (driver_of(name) == "ftdi_sio")


def test_a_chip_that_makes_14400_of_10400_is_said_to(model):
    """Of the chips with one id, some may, and those are named in the text."""
    name, device = model
    if name == "PL2303 unknown":  # no driver opens it
        return
    opened(device, name, TENS)
    chip, quirks = said(device)
    if device.uart.settings.fits(Settings(TENS)):
        return
    assert device.uart.settings.rate == dict(LISTED)[14428] == 14400
    assert has_usual_rates(chip)
    assert any(name in quirk.en and name in quirk.ru for quirk in quirks)


def test_short_packets_are_said_to_be_held_back_of_those_alone_that_can(model):
    name, device = model
    lumps = any("lumps of 32" in quirk.en for quirk in said(device)[1])
    assert lumps == hasattr(device, "holds_back") == (driver_of(name) == "ch341")
