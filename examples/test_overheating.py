"""A program's own tests, with a virtual unit whose values, faults, line and cable they command.

`pytest examples/test_overheating.py`. The fixtures `car` and `virtual_ecu` come with mikas; time is
simulated: five minutes pass in no time.
"""

from __future__ import annotations

import pytest

import mikas
from mikas.testing import LineFault, VirtualUnit


def warning_of(ecu: mikas.Ecu) -> str:
    """Return the program's verdict: what is tested here."""
    try:
        coolant = ecu.read("TWAT")["TWAT"].value
    except mikas.errors.LineError:
        return "no reading"
    return "too hot" if coolant > 105 else "fine"


def test_a_hot_engine(car: VirtualUnit, virtual_ecu: mikas.Ecu) -> None:
    assert warning_of(virtual_ecu) == "fine"
    car.set("TWAT", 110)
    assert warning_of(virtual_ecu) == "too hot"


def test_a_bad_line(car: VirtualUnit, virtual_ecu: mikas.Ecu) -> None:
    car.next_responses(LineFault.LOST)
    assert warning_of(virtual_ecu) == "fine"  # it was repeated
    car.next_responses(*[LineFault.DAMAGED] * 9)
    assert warning_of(virtual_ecu) == "no reading"


@pytest.mark.mikas_car(scenario="cold-start", faults="17,81")
def test_five_minutes_later(car: VirtualUnit, virtual_ecu: mikas.Ecu) -> None:
    assert [fault.code for fault in virtual_ecu.faults()] == [17, 81]
    cold = virtual_ecu.read("TWAT")["TWAT"].value
    car.pass_time(300)
    assert virtual_ecu.read("TWAT")["TWAT"].value > cold + 20


def test_a_cable_that_is_pulled_out(car: VirtualUnit, virtual_ecu: mikas.Ecu) -> None:
    car.unplug()
    with pytest.raises(mikas.errors.LinkLost):
        warning_of(virtual_ecu)
    with car.connect() as again:
        assert warning_of(again) == "fine"
