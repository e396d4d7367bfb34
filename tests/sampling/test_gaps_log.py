"""The logger `mikas.sampling`: states, the unit, the method, and gaps at INFO."""

from __future__ import annotations

import logging

from sampling_harness import SimulatedPlug, ecu_factory, take

from mikas.catalog import shipped
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.events import MethodChosen, ParameterDropped, Sampled
from mikas.sampling.session import SamplingSession, log
from virtual_harness import make_bus


def lines(caplog):
    return [record.getMessage() for record in caplog.records if record.name == "mikas.sampling"]


def sample(bus, until):
    acquisition = Acquisition(SimulatedPlug(bus), ecu_factory(), shipped(), ["TWAT"])
    return take(SamplingSession().run(acquisition), until)


def count(kind, events):
    return sum(isinstance(event, kind) for event in events)


def test_states_the_unit_and_the_method_are_logged(caplog):
    with caplog.at_level(logging.INFO, logger="mikas.sampling"):
        sample(make_bus(), lambda events: count(MethodChosen, events) > 0)
    logged = lines(caplog)
    assert "state: the ECU answers" in logged
    assert "state: sampling" in logged
    assert any(line.startswith("unit: version 0A, passport: ") for line in logged)
    assert any(line.startswith("method: ") and "/s" in line for line in logged)
    assert len(logged) < 8  # no line for a value


def test_the_beginning_and_the_end_of_a_gap_are_logged(caplog):
    bus = make_bus()

    def until(events):
        samples = count(Sampled, events)
        bus.ecu.responder.car.on = not (40 < samples < 42 and len(events) < 400)
        return samples > 60

    with caplog.at_level(logging.INFO, logger="mikas.sampling"):
        sample(bus, until)
    began = [line for line in lines(caplog) if line.startswith("gap began: ")]
    ended = [line for line in lines(caplog) if line.startswith("gap ended after ")]
    assert len(began) == len(ended) >= 1


def test_a_refused_parameter_is_logged(caplog):
    with caplog.at_level(logging.INFO, logger="mikas.sampling"):
        log(ParameterDropped(1.0, "TWAT"))
    assert lines(caplog) == ["no valid answer for TWAT: dropped"]


def test_nothing_is_logged_by_default(capfd):
    logger = logging.getLogger("mikas.sampling")
    assert not logger.isEnabledFor(logging.INFO)
    assert any(isinstance(handler, logging.NullHandler) for handler in logger.handlers)
    sample(make_bus(), lambda events: count(Sampled, events) > 3)
    assert capfd.readouterr() == ("", "")
