"""The supply, and what a unit keeps without it: faults, writes, memory, pinned values."""

from __future__ import annotations

import pytest

from mikas import commands as c
from mikas.catalog import shipped
from mikas.errors import EchoOnly, UnknownParameter, UsageError, ValueDoesNotFit
from mikas.framing import encode
from mikas.link.virtual import VirtualLink
from mikas.tester import Tester as Client
from mikas.virtual.build import build_bus
from mikas.virtual.bus import Bus
from mikas.virtual.cars import EngineCar, pinned
from mikas.virtual.ecu import VirtualEcu
from mikas.virtual.memory import SIZES, EcuMemory, pattern
from mikas.virtual.model.engine import Engine
from mikas.virtual.quirks import EcuQuirks
from mikas.virtual.responder import Responder
from mikas.virtual.scenarios.scenario import SCENARIOS
from protocol_codes import CODES, SIMULATED
from virtual_harness import DATA, FAULTS, connected, make_bus

from .raw_tester import BYTE, RawTester

CATALOG = shipped()
NO, YES = encode(b"\x01"), encode(b"\x00")


def turned_off_and_on(tester: RawTester) -> None:
    car = tester.bus.ecu.responder.car
    car.on = False
    assert tester.ask(b"\x01") == b""
    car.on = True


def test_a_unit_without_supply_is_silent_and_forgets_pending_responses():
    bus = make_bus()
    tester = RawTester(bus)
    tester.say(b"\x01\xff\x0d")
    tester.listen(3.5 * BYTE)
    bus.ecu.responder.car.on = False
    assert tester.listen(1.0) == b""


def test_a_power_cycle_restores_volatile_data_only():
    tester = RawTester(make_bus())
    before = {read: tester.ask(read) for read in (b"\x11\x10", b"\x13\x10\x20", b"\x31\x10")}
    for write in ("12 10 99", "14 10 20 99", "16 10 20 99", "32 10 99", "62 1A 99", "64 1A"):
        assert tester.ask(bytes.fromhex(write)) not in (b"", NO)
    assert tester.ask(b"\x63") == encode(b"\x99")
    turned_off_and_on(tester)
    for read, was in before.items():
        assert tester.ask(read) == was
    assert tester.ask(b"\x15\x10\x20") == encode(b"\x10\x20\x99")  # CODE stays
    assert tester.ask(b"\x61\x1a") == encode(DATA[0x1A])
    assert tester.ask(b"\x63") == NO  # no list
    assert tester.ask(b"\x02") == encode(c.ReadFaults().respond(tuple(FAULTS)))


def test_a_power_cycle_ends_a_stream_and_a_request_under_way():
    tester = RawTester(make_bus())
    tester.say(encode(b"\x71\x1a"))
    assert len(tester.listen(0.5)) > 100
    tester.bus.ecu.responder.car.on = False
    tester.listen(0.6)
    assert tester.listen(1.0) == b""
    tester.bus.ecu.responder.car.on = True
    assert tester.listen(2.0) == b""
    tester.say(b"\x01\xff")
    tester.listen(tester.now + 2.1 * BYTE)
    turned_off_and_on(tester)
    assert tester.ask(b"\x01") == b"\x0a\xf6\x0d"


def test_the_supply_cuts_a_response_short():
    """key-off turns the key at second 20: nothing comes after that, not even the rest of a byte."""
    tester = RawTester(build_bus({"scenario": "key-off"}))
    tester.say(encode(b"\x71" + bytes(DATA)), at=19.0)
    tester.listen(30.0)
    assert 19.9 < tester.times[-1] <= 20.0
    tester.listen(50.0)
    assert tester.times[-1] <= 20.0


def test_a_unit_without_supply_sends_no_late_response():
    tester = RawTester(build_bus({"scenario": "key-off", "late": "1", "late_by": "2"}))
    tester.say(b"\x01\xff\x0d", at=19.5)
    tester.listen(30.0)
    assert tester.data == b"\x01\xff\x0d"


def test_a_turn_of_the_key_is_seen_from_end_to_end():
    link = VirtualLink(build_bus({"scenario": "key-off"}))
    tester = Client(link)
    tester.connect()
    tester.request(c.WriteCodeByte(0x8000, 0x77))
    tester.request(c.WriteRamByte(0x80, tester.request(c.ReadRamByte(0x80)) ^ 0xFF))
    changed = tester.request(c.ReadRamByte(0x80))
    tester.request(c.WriteList((c.Datum(0x1A, 1),)))
    tester.wait(21.0)
    with pytest.raises(EchoOnly):
        tester.request(c.ReadFaults())
    tester.wait(36.0)
    assert tester.request(c.ReadFaults()) == ()
    assert tester.request(c.ReadCodeByte(0x8000)) == 0x77
    assert tester.request(c.ReadRamByte(0x80)) == changed ^ 0xFF
    assert tester.request(c.ReadParameters((c.Datum(0x29, 1),)))[0] == b"\x00"  # standing
    tester.wait(45.0)
    assert tester.request(c.ReadParameters((c.Datum(0x29, 1),)))[0] > b"\x0a"  # started again


def test_the_watcher_receives_events():
    observed = []
    bus = build_bus({"scenario": "key-off"}, watcher=lambda h: observed.append((h.kind, h.data)))
    tester = RawTester(bus, now=0.0)
    tester.ask(b"\x01")
    tester.ask(b"\x99")
    tester.say(b"\x01\xfe\x0d")
    tester.say(encode(b"\x7f\x1a"), at=2.0)
    tester.listen(2.0 + 4.1 * BYTE)
    tester.say(b"\xff", at=2.1)
    tester.listen(40.0)
    kinds = [kind for kind, _ in observed]
    assert kinds[:6] == ["request", "response", "request", "silence", "damaged", "request"]
    assert kinds[6] == "stream"
    assert kinds[-3:] == ["stream-end", "power-off", "power-on"]
    assert observed[1] == ("response", b"\x0a")
    assert observed[4] == ("damaged", b"\x01\xfe")


# Faults


@pytest.mark.parametrize(
    ("bodies", "erased"),
    [
        (["62 0E 08", "62 0E 00"], True),
        (["62 0E 08", "62 0E 08", "62 0E 00"], True),
        (["62 0E 00"], False),
        (["62 0E 00", "62 0E 08"], False),
        (["62 0E 08", "02", "62 0E 00"], False),
        (["62 0E 08", "01", "62 0E 00"], False),
        (["62 0E 08", "99", "62 0E 00"], False),
        (["62 0E 08", "51", "62 0E 00"], False),  # a command that it lacks
        (["62 0E 08", "62 0E 01", "62 0E 00"], False),
        (["62 0E 08", "62 0E 00 00", "62 0E 00"], False),
    ],
)
def test_faults_are_erased_by_08_and_then_00_in_a_row(bodies, erased):
    tester = RawTester(make_bus(quirks=EcuQuirks().with_options({"missing": "passports"})))
    *_, last = [tester.ask(bytes.fromhex(body)) for body in bodies]
    if bodies[-1] == "62 0E 00":
        assert last == (YES if erased else NO)  # D17: 00 only if it erased
    assert tester.ask(b"\x02") == encode(
        b"\x00" if erased else c.ReadFaults().respond(tuple(FAULTS))
    )


def test_the_writes_of_the_erase_are_answered():
    tester = RawTester(make_bus())
    assert tester.ask(b"\x62\x0e\x08") == YES
    assert tester.ask(b"\x62\x0e\x00") == YES
    assert tester.ask(b"\x62\x0e\x07") == NO


def test_a_power_cycle_between_the_two_writes_saves_the_faults():
    tester = RawTester(make_bus())
    tester.ask(b"\x62\x0e\x08")
    turned_off_and_on(tester)
    tester.ask(b"\x62\x0e\x00")
    assert tester.ask(b"\x02") != encode(b"\x00")


def test_of_more_faults_than_the_answer_can_count_255_are_reported():
    every = ",".join(map(str, range(256)))
    tester = Client(VirtualLink(build_bus({"faults": every})))
    tester.connect()
    assert tester.request(c.ReadFaults()) == tuple(range(255))


def test_faults_are_listed_once_each_those_of_the_scenario_first(tmp_path):
    path = tmp_path / "faulty.toml"
    path.write_text("duration = 60\nfaults = [53, 13]\n[timeline]\nthrottle = 0\n")
    tester = Client(VirtualLink(build_bus({"scenario": str(path), "faults": "21 13"})))
    tester.connect()
    assert tester.request(c.ReadFaults()) == (13, 53, 21)


def ask(tester, name: str) -> float:
    parameter = CATALOG.parameter(name)
    datum = c.Datum(parameter.code, parameter.size)
    return parameter.decode(tester.request(c.ReadParameters((datum,)))[0])


def engine_tester(**settings: str):
    tester = Client(VirtualLink(build_bus(settings)))
    tester.connect()
    return tester


def test_erasing_a_fault_takes_its_sensors_substitute_away():
    tester = engine_tester(faults="17")
    assert ask(tester, "MINERR") == 17
    with_fault = ask(tester, "TAIR")
    sound = ask(engine_tester(), "TAIR")
    assert with_fault == 20
    assert with_fault != sound
    for write in c.ERASE_FAULTS:
        tester.request(write)
    tester.wait(tester.link.now() + 1)
    assert tester.request(c.ReadFaults()) == ()
    assert ask(tester, "MINERR") == 0
    assert ask(tester, "TAIR") == pytest.approx(sound, abs=1)


def test_a_later_fault_is_applied():
    tester = engine_tester()
    tester.link.bus.ecu.responder.car.faults += [195, 53, 13]
    tester.wait(tester.link.now() + 1)
    assert ask(tester, "MINERR") == 13
    assert tester.request(c.ReadFaults()) == (195, 53, 13)
    assert ask(tester, "FREQ") == 0  # no crank signal


# Pinned and written values

PINNED = """
duration = 60
faults = [13, 64]
passports = ["МИКАС 7.1", "ТЕСТ", "", "", "ПЯТЫЙ"]
[start]
running = true
coolant = 86
[timeline]
throttle = 0
[values]
TWAT = 91
uacc = 13.9
JAIR = 15.25
RXX = true
RDET = true
BITPOW = false
[raw]
FREQ = "15"
"0x3F" = "0D 40"
"0x99:2" = "12 34"
[memory.ram]
10 = "0D 40"
[memory.code]
"7FFE" = "01 02 03"
"""


@pytest.fixture
def pinned_tester(tmp_path):
    path = tmp_path / "pinned.toml"
    path.write_text(PINNED, "utf-8")
    return engine_tester(scenario=str(path))


def test_a_scenarios_values_stand_over_the_engines(pinned_tester):
    for _ in range(2):
        assert ask(pinned_tester, "TWAT") == 91
        assert ask(pinned_tester, "UACC") == 13.9
        assert ask(pinned_tester, "JAIR") == 15.25
        assert ask(pinned_tester, "RXX") is True
        assert ask(pinned_tester, "RDET") is True
        assert ask(pinned_tester, "BITPOW") is False
        assert ask(pinned_tester, "FREQ") == 0x15 * 40
        assert ask(pinned_tester, "INJ") == 0x400D / 125
        assert ask(pinned_tester, "0x99:2") == 0x3412
        assert ask(pinned_tester, "MINERR") == 13
        assert 9 < ask(pinned_tester, "FREQX") / 85 < 11  # left to the engine
        pinned_tester.wait(pinned_tester.link.now() + 30)


def test_passports_and_memory_of_a_scenario_are_the_units(pinned_tester):
    assert pinned_tester.request(c.ReadProgramPassport(1)) == "МИКАС 7.1"
    assert pinned_tester.request(c.ReadDataPassport(2)) == "ПЯТЫЙ"
    assert pinned_tester.request(c.ReadRamBlock(0x10, 3))[:2] == b"\x0d\x40"
    assert pinned_tester.request(c.ReadCodeBlock(0x7FFE, 3)) == b"\x01\x02\x03"
    assert pinned_tester.request(c.CountParameters()) == SIMULATED + 1  # 0x99


def test_a_written_parameter_stands_until_the_power_goes():
    tester = engine_tester(scenario="key-off")
    sound = ask(tester, "TWAT")
    tester.request(c.WriteParameter(0x1A, b"\x10"))
    assert ask(tester, "TWAT") == -24
    tester.wait(19.0)
    assert ask(tester, "TWAT") == -24
    tester.wait(36.0)
    assert ask(tester, "TWAT") == pytest.approx(sound, abs=6)


def test_a_written_parameter_stands_over_a_pinned_one(pinned_tester):
    pinned_tester.request(c.WriteParameter(0x1A, b"\x00"))
    assert ask(pinned_tester, "TWAT") == -40


def test_flags_that_share_a_byte_are_put_together():
    assert pinned(CATALOG, {}, {"RXX": True, "RDET": True}) == {7: b"\x84"}
    assert pinned(CATALOG, {"0x07": b"\xff"}, {"BITPOW": False}) == {7: b"\xdf"}
    assert pinned(CATALOG, {}, {"DET": False}) == {8: b"\x00"}


def test_what_can_not_be_pinned_is_refused():
    with pytest.raises(UnknownParameter):
        pinned(CATALOG, {}, {"TWATT": 1})
    with pytest.raises(ValueDoesNotFit):
        pinned(CATALOG, {}, {"TWAT": 400})


@pytest.mark.parametrize("raw", [{"TWAT": b"\x01\x02"}, {"0x3F": b"\x01"}, {"0x99": bytes(5)}])
def test_a_pinned_datum_has_its_parameters_size(raw):
    with pytest.raises(UsageError):
        pinned(CATALOG, raw, {})


def test_every_value_of_the_engine_reads_back_as_it_is():
    """The unit says what the model says, to a step of the raw number; RCOK by the letter (E3)."""
    engine = Engine(SCENARIOS["warm-idle"], 3)
    car = EngineCar(engine, CATALOG)
    tester = connected_to(car)
    assert set(CODES) <= set(car.codes)
    assert -0.6 < ask(tester, "RCOK") < -0.4  # 128, give or take: no correction
    assert -0.6 < ask(tester, "RCOD") < -0.4
    assert 80 <= ask(tester, "TWAT") <= 95
    assert 800 <= ask(tester, "FREQ") <= 900
    assert ask(tester, "RXX") is True
    assert ask(tester, "BITPOW") is False


def connected_to(car):
    tester = Client(VirtualLink(Bus(VirtualEcu(Responder(car)))))
    tester.connect()
    return tester


# Memory


def test_every_space_holds_its_pattern_and_written_bytes():
    tester = connected()
    blocks = {"ram": c.ReadRamBlock, "xram": c.ReadXramBlock, "code": c.ReadCodeBlock}
    for space, block in blocks.items():
        address = SIZES[space] - 0x80
        assert tester.request(block(address, 0x80)) == pattern(space)[address:]
    for space in SIZES:
        assert set(pattern(space)) == set(range(256))
        assert all(a != b for a, b in zip(pattern(space), pattern(space)[1:], strict=False))
    assert len({pattern(space)[:256] for space in SIZES}) == 4


def test_two_units_do_not_share_memory():
    one, other = EcuMemory(), EcuMemory({"ram": {0: b"\x99"}})
    one.write("xram", 0x1000, b"\x01\x02")
    assert one.read("xram", 0x1000, 2) == b"\x01\x02"
    assert other.read("xram", 0x1000, 2) == pattern("xram")[0x1000:0x1002]
    other.write("ram", 0, b"\x77")
    other.power_cycle()
    assert other.read("ram", 0) == b"\x99"  # what it was made with, not the pattern
