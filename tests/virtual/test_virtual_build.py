"""Settings as text: what `sim:` URLs and `mikas sim` give; and the ELM327 among them."""

from __future__ import annotations

import pytest

import mikas
from mikas.errors import BadPortUrl, CatalogError, NotAKLineAdapter, UsageError
from mikas.link import open_link
from mikas.link.virtual import RealTimeVirtualLink, VirtualLink
from mikas.virtual.build import MODELS, SETTINGS, build_bus
from mikas.virtual.bus import LONGEST_LINE, Elm327
from mikas.virtual.fault_injector import LATE_BY, LineFault
from mikas.virtual.quirks import EcuQuirks
from mikas.virtual.scenarios.scenario import SCENARIOS

from .raw_tester import BYTE, RawTester


def test_settings_have_distinct_names():
    assert len(set(SETTINGS)) == len(SETTINGS)


def test_with_no_settings_it_is_a_warm_71_on_a_plain_adapter():
    bus = build_bus({})
    responder = bus.ecu.responder
    assert responder.identity.version_code == 0x0A
    assert responder.car.engine.scenario.name == "warm-idle"
    assert responder.quirks == EcuQuirks()
    assert (bus.ecu.baud, bus.byte_time) == (9600, BYTE)
    assert (bus.adapter.kind.echo, bus.adapter.kind.latency, bus.adapter.kind.supplied) == (
        True,
        0,
        True,
    )
    assert bus.fault_injector.rates == {}
    assert bus.fault_injector.late_by == LATE_BY


def test_every_setting_arrives():
    bus = build_bus(
        {
            "scenario": "city",
            "seed": "7",
            "model": "5.4",
            "faults": "13,53",
            "baud": "10400",
            "adapter": "kkl",
            "echo": "off",
            "latency_ms": "16",
            "supplied": "0",
            "late_by": "1.5",
            "turn_round": "0.01",
            "missing": "list+71",
            "damaged": "0.25",
            "bad-echo": "0.5",
        }
    )
    responder, kind = bus.ecu.responder, bus.adapter.kind
    assert responder.car.engine.scenario.name == "city"
    assert responder.identity.version_code == 0x09
    assert "5.4" in responder.identity.passports[0]
    assert responder.car.faults == [13, 53]
    assert bus.ecu.baud == 10400
    assert (kind.echo, kind.latency, kind.supplied) == (False, 0.016, False)
    assert bus.fault_injector.rates == {LineFault.DAMAGED: 0.25, LineFault.ECHO: 0.5}
    assert bus.fault_injector.late_by == 1.5
    assert responder.quirks.turn_round == 0.01
    assert responder.quirks.missing == {0x63, 0x64, 0x71}


@pytest.mark.parametrize("text", ["13,53", "13+53", "13 53", " 13, 53 ", "13,,53,"])
def test_faults_are_taken_in_any_spelling(text):
    assert build_bus({"faults": text}).ecu.responder.car.faults == [13, 53]


@pytest.mark.parametrize("on", ["1", "on", "yes", "TRUE"])
def test_echo_on_sets_the_adapter_and_no_line_fault(on):
    bus = build_bus({"echo": on})
    assert bus.adapter.kind.echo
    assert bus.fault_injector.rates == {}


@pytest.mark.parametrize(
    ("name", "value", "allowed"),
    [
        ("scenario", "no-such", "warm-idle"),
        ("seed", "x", "0, 1, 2"),
        ("model", "7.2", "5.4, 7.1"),
        ("faults", "256", "13,53"),
        ("faults", "P0101", "13,53"),
        ("faults", "-1", "13,53"),
        ("baud", "49", "50 … 4000000"),
        ("baud", "fast", "50 … 4000000"),
        ("adapter", "elm", "kkl, elm327"),
        ("echo", "2", "0, 1"),
        ("latency_ms", "-1", "0 … 1000"),
        ("latency_ms", "nan", "0 … 1000"),
        ("supplied", "", "0, 1"),
        ("late_by", "61", "0 … 60"),
        ("turn_round", "x", "0 … 10"),
        ("lost", "2", "0 … 1"),
        ("max-list", "2", "max_list"),
        ("quux", "2", "scenario"),
    ],
)
def test_an_invalid_value_is_reported_with_the_allowed_ones(name, value, allowed):
    with pytest.raises(UsageError) as caught:
        build_bus({name: value})
    assert allowed in caught.value.text.en
    assert allowed in caught.value.text.ru
    with pytest.raises(BadPortUrl) as caught:
        open_link("sim:", **{name: value})
    assert allowed in caught.value.text.en
    assert allowed in caught.value.text.ru
    assert "sim:" in caught.value.text.en


def test_an_invalid_scenario_file_is_reported_by_file_and_line(tmp_path):
    path = tmp_path / "bad.toml"
    path.write_text("duration = 60\nspeed = 3\n")
    with pytest.raises(CatalogError) as caught:
        open_link("sim:", scenario=str(path))
    assert caught.value.line == 2


@pytest.mark.parametrize("name", SCENARIOS)
def test_every_scenario_can_be_had(name):
    tester = RawTester(build_bus({"scenario": name}))
    assert tester.ask(b"\x01") == b"\x0a\xf6\x0d"


@pytest.mark.parametrize("model", MODELS)
def test_each_model_has_its_version_code(model):
    tester = RawTester(build_bus({"model": model}))
    assert tester.ask(b"\x01")[0] == MODELS[model]


# sim:


def test_the_clock_is_simulated_or_real_as_set():
    with open_link("sim:?clock=simulated&seed=3") as link:
        assert isinstance(link, VirtualLink)
        assert link.now() == 0
        assert link.url == "sim:?clock=simulated&seed=3"
    with open_link("sim:") as link:
        assert isinstance(link, RealTimeVirtualLink)
        assert link.now() > 1.6e9


@pytest.mark.parametrize(
    ("url", "problem"),
    [("sim:?clock=fast", "allowed: real, simulated"), ("sim:warm-idle", r"\?scenario=warm-idle")],
)
def test_urls_that_make_no_sense_are_refused(url, problem):
    with pytest.raises(BadPortUrl, match=problem):
        open_link(url)


def test_the_same_seed_and_the_same_questions_give_the_same_bytes():
    def heard(seed):
        tester = RawTester(build_bus({"scenario": "city", "seed": seed, "damaged": "0.1"}))
        for body in (b"\x61\x29\x3f\x21", b"\x02", b"\x61\x1e") * 20:
            tester.ask(body)
        tester.say(bytes.fromhex("7F 29 58 0D"))
        tester.listen(tester.now + 20)
        return tester.heard

    assert heard("1") == heard("1")
    assert heard("1") != heard("2")


# ELM327


def elm() -> RawTester:
    bus = build_bus({"adapter": "elm327"})
    assert isinstance(bus, Elm327)
    return RawTester(bus)


@pytest.mark.parametrize("echo", ["auto", "on", "off"])
def test_the_tester_says_what_it_is(echo, tmp_path):
    with pytest.raises(NotAKLineAdapter):
        mikas.connect(
            "sim:?adapter=elm327&clock=simulated",
            echo=echo,
            journal=tmp_path / "journal",
            state=tmp_path,
        )


def test_it_does_not_understand_a_request():
    tester = elm()
    tester.say(b"\x01\xff\x0d")
    assert tester.listen(1.0) == b"\x01\xff\x0d?\x0d\x0d>"


@pytest.mark.parametrize(
    ("sent", "heard"),
    [
        (b"ATI\r", b"ATI\rELM327 v1.5\r\r>"),
        (b"at z\r", b"at z\r\r\rELM327 v1.5\r\r>"),
        (b"ATE0\rATI\r", b"ATE0\rOK\r\r>ELM327 v1.5\r\r>"),
        (b"ATE0\rATE1\rATI\r", b"ATE0\rOK\r\r>OK\r\r>ATI\rELM327 v1.5\r\r>"),
        (b"0100\r", b"0100\r?\r\r>"),
        (b"\x00\x00ATI\r", b"ATI\rELM327 v1.5\r\r>"),
        (b"ATI", b"ATI"),
    ],
)
def test_an_elm327_answers_as_an_elm327(sent, heard):
    tester = elm()
    tester.say(sent)
    assert tester.listen(1.0) == heard


def test_its_bytes_take_their_time():
    tester = elm()
    tester.say(b"ATI\r")
    tester.listen(1.0)
    # Each character comes back while the next one is being sent.
    expected = [(n + 2) * BYTE for n in range(len(tester.heard))]
    assert tester.times == pytest.approx(expected)


def test_a_line_without_an_end_is_bounded_and_a_break_clears_it():
    tester = elm()
    tester.say(b"A" * 1000)
    tester.listen(2.0)
    assert len(tester.bus._line) == LONGEST_LINE  # noqa: SLF001
    tester.bus.send_break(0.01, tester.now)
    tester.say(b"ATI\r", at=2.1)
    assert tester.listen(3.0) == b"ATI\rELM327 v1.5\r\r>"


def test_the_unit_behind_it_hears_nothing():
    tester = elm()
    tester.say(b"\x01\xff\x0d")
    tester.listen(1.0)
    assert tester.bus.bytes_carried == 0
