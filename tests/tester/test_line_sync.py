"""D13: whatever happens on the line, a value is the answer to its own request, or there is none."""

from __future__ import annotations

from collections import Counter
from contextlib import suppress
from random import Random

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from tester_rig import (
    ADAPTERS,
    DATA,
    ECHOING,
    ONE_BYTE,
    READS,
    Fate,
    Watched,
    adapter_name,
    case,
    read,
    right,
)

from mikas import commands as c
from mikas.errors import EchoOnly, MikasError, NoEcho, SyncLost
from mikas.link import CaptureTee
from mikas.virtual.fault_injector import FaultInjector, LineFault

EARLIEST, LATEST = 0.05, 0.95  # s behind its time that a late response comes

line_faults = st.sampled_from([*LineFault, LineFault.LATE, LineFault.LATE, LineFault.LOST, None])
fates = st.lists(st.tuples(line_faults, st.floats(EARLIEST, LATEST)), max_size=30)
LATE, LOST, OK = LineFault.LATE, LineFault.LOST, None


def some_of(codes):
    return st.lists(st.sampled_from(sorted(codes)), min_size=1, max_size=12)


def never_anothers(codes, fates, adapter, seed=0, **settings):
    unit = Watched(adapter=adapter)
    tester = unit.connected(**settings)
    unit.bus.fault_injector = Fate(fates, seed)
    got = 0
    for code in codes:
        try:
            assert tester.request(read(code)) == (DATA[code],)
            got += 1
        except MikasError:
            pass
    return got


each_adapter = pytest.mark.parametrize("adapter", ADAPTERS, ids=adapter_name)


@each_adapter
@given(codes=some_of(ONE_BYTE), fates=fates, seed=st.integers(0, 9), retries=st.integers(0, 3))
@settings(max_examples=100)
# Two answers to 01 are late: the first is taken for the second's, the second for a datum.
@example([17, 17, 17, 17], [(LOST, 0), (LATE, 0.7), (LATE, 0.45), (LOST, 0)], 0, 0)
@example([17, 17, 17, 17], [(LOST, 0), (LATE, 0.95), (LATE, 0.95), (LOST, 0)], 0, 0)
# The step is sought after damage, which says that nothing is under way; then 01's answer is late.
@example([17, 17, 17, 17], [(LineFault.DAMAGED, 0), (LATE, 0.7), (LATE, 0.55), (LOST, 0)], 0, 0)
# A late datum that looks like the unit's own answer to 01.
@example([16, 22, 22], [(LATE, 0.6), (LOST, 0), (LOST, 0)], 0, 0)
@example([16, 22, 22], [(LATE, 0.95), (LATE, 0.95), (LOST, 0)], 0, 0)
# The second copy meets the next request, and no echo marks it.
@example([16, 16, 17, 18, 18], [(LineFault.DOUBLED, 0)] * 5, 0, 0)
def test_no_value_is_ever_that_of_another_parameter(adapter, codes, fates, seed, retries):
    never_anothers(codes, fates, adapter, seed, retries=retries)


@each_adapter
@given(codes=some_of(DATA), fates=fates, seed=st.integers(0, 9))
@settings(max_examples=50)
def test_no_value_of_mixed_sizes_is_that_of_another_parameter(adapter, codes, fates, seed):
    never_anothers(codes, fates, adapter, seed)


@given(codes=some_of(ONE_BYTE), fates=fates, seed=st.integers(0, 9))
@settings(max_examples=50)
def test_no_value_after_a_pause_is_that_of_another_parameter(codes, fates, seed):
    unit = Watched()
    tester = unit.connected()
    unit.bus.fault_injector = Fate(fates, seed)
    for code in codes:
        with suppress(MikasError):
            assert tester.request(read(code)) == (DATA[code],)
        tester.wait(unit.link.now() + 0.01 * code)


@each_adapter
@pytest.mark.parametrize("line_fault", [t for t in LineFault if t is not LineFault.FOREIGN])
def test_a_retry_survives_one_line_fault(adapter, line_fault):
    for late in (0.05, 0.3, 0.49, 0.495, 0.498, 0.5, 0.505, 0.51, 0.6, 0.95):
        with case(late):
            assert never_anothers([16, 17, 22, 67] * 2, [(line_fault, late)], adapter) == 8


@each_adapter
def test_in_heavy_weather_some_reads_succeed_and_none_is_wrong(adapter):
    """Thousands of reads, a line fault in every second response: some succeed, none is wrong."""
    random = Random(1)
    codes = random.choices(sorted(DATA), k=500)
    kinds = [*LineFault, *[None] * len(LineFault)]
    fates = [(random.choice(kinds), random.uniform(EARLIEST, LATEST)) for _ in range(3000)]
    assert never_anothers(codes, fates, adapter) > 250


class Wire:
    """A sink that keeps every byte and its time."""

    def __init__(self):
        self.observed = []

    def record(self, direction, data, time):
        self.observed.append((direction.value, data, time))


def drive(seed: int, reads: int, rate: float, pause: float = 0.0):
    fault_injector = FaultInjector(dict.fromkeys(LineFault, rate), seed=seed, late_by=0.7)
    unit = Watched(fault_injector=fault_injector)
    wire = Wire()
    tester = unit.tester(CaptureTee(unit.link, wire))
    tester.connect()
    random = Random(seed)
    results = Counter()
    for _ in range(reads):
        code = random.choice(sorted(DATA))
        try:
            assert tester.request(read(code)) == (DATA[code],)
            results["right"] += 1
        except MikasError as error:
            results[type(error).__name__] += 1
        unit.link.gather(unit.link.now() + pause)  # the application does something else
    return unit, tester, results, wire.observed


def test_eight_hours_of_driving_with_a_thousand_line_faults():
    unit, tester, results, _ = drive(seed=4, reads=6000, rate=0.018, pause=4.7)
    assert unit.link.now() > 8 * 3600
    assert unit.fault_injector.count > 1000
    assert results["right"] > 5950
    assert tester.statistics.failed > 500
    assert tester.sync.found_again > 500
    right(tester)


def test_the_same_seed_gives_the_same_bytes_at_the_same_times():
    first, second, other = (drive(seed, 300, 0.03)[3] for seed in (7, 7, 8))
    assert first == second
    assert first != other


def test_what_came_unasked_is_found_at_the_next_request():
    unit = Watched()
    tester = unit.connected()
    unit.bus.unit.transmit(b"\x0a\xf6\x0d", unit.link.now())
    tester.wait(unit.link.now() + 0.1)
    asked = unit.heard(b"\x01")
    right(tester)
    assert unit.heard(b"\x01") == asked + 1
    assert tester.sync.found_again == 1


def test_waiting_ends_on_time_and_keeps_the_synchronization_of_a_quiet_line():
    unit = Watched()
    tester = unit.connected()
    for seconds in (0.005, 0.05):
        until = unit.link.now() + seconds
        tester.wait(until)
        assert unit.link.now() == until
    right(tester)
    assert tester.sync.found_again == 0


def test_no_confirmation_is_sent_on_a_healthy_line():
    unit = Watched()
    tester = unit.connected()
    asked = unit.heard(b"\x01")
    for _ in range(20):
        right(tester)
    assert unit.heard(b"\x01") == asked
    assert tester.sync.found_again == 0


def test_after_silence_the_confirmation_comes_when_nothing_can_be_under_way_any_more():
    unit = Watched()
    tester = unit.connected()
    tester.raw(b"\x41\x00\x80")
    began = unit.link.now()  # 0.5 s after the request
    right(tester, 16)
    assert 0.5 < unit.link.now() - began < 0.7


def test_after_plain_damage_it_goes_on_at_once():
    unit = Watched(fault_injector=Fate([(OK, 0)] * 3 + [(LineFault.MISSING_BYTE, 0)], seed=1))
    tester = unit.connected()
    began = unit.link.now()
    right(tester, 22)
    assert tester.statistics.repeated == 1
    assert unit.link.now() - began < 0.3


@pytest.mark.parametrize("adapter", [ECHOING, ADAPTERS[1]], ids=adapter_name)
def test_a_unit_that_is_gone_is_reported_and_found_again(adapter):
    unit = Watched(adapter=adapter)
    tester = unit.connected()
    right(tester)
    unit.car.on = False
    for _ in range(2):
        began = unit.link.now()
        with pytest.raises(EchoOnly if adapter.echo else NoEcho):
            tester.request(read(16))
        assert unit.link.now() - began < 5
    unit.car.on = True
    right(tester)


def test_an_adapter_that_loses_its_supply_has_its_own_error():
    unit = Watched()
    tester = unit.connected()
    kind = unit.bus.adapter.kind
    object.__setattr__(kind, "supplied", False)
    try:
        with pytest.raises(NoEcho):
            tester.request(read(16))
    finally:
        object.__setattr__(kind, "supplied", True)
    right(tester)


def test_a_unit_swapped_for_another_model_is_out_of_step():
    unit = Watched()
    tester = unit.connected(retries=0)
    unit.ecu.responder.identity = unit.ecu.responder.identity.__class__(0x09)
    unit.fault_injector.next(LOST)
    with pytest.raises(MikasError):
        tester.request(read(16))
    with pytest.raises(SyncLost):
        tester.request(read(16))
    assert tester.connect() == 0x09
    right(tester)


def test_other_commands_keep_to_their_own_responses_too():
    """Commands of all families by turns, in bad weather."""
    unit = Watched()
    wanted = [*READS, c.ReadRamByte(0x0D), c.ReadRamByte(0x40), c.ReadXramByte(0x0D40)]
    tester = unit.connected()
    truth = {command: tester.request(command) for command in wanted}
    random = Random(3)
    kinds = [*LineFault, *[None] * len(LineFault)]
    unit.bus.fault_injector = Fate(
        (random.choice(kinds), random.uniform(EARLIEST, LATEST)) for _ in range(5000)
    )
    good = 0
    for _ in range(400):
        command = random.choice(wanted)
        try:
            assert tester.request(command) == truth[command]
            good += 1
        except MikasError:
            pass
    assert good > 200
