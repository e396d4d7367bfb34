"""Connecting: who is there, and does the line echo (D1)."""

from __future__ import annotations

import itertools

import pytest
from tester_rig import (
    ADAPTERS,
    DATA,
    DEAD,
    ECHOING,
    SILENT_ADAPTER,
    SLOW,
    VERSION,
    Fate,
    ScriptedLink,
    StrikingLink,
    Watched,
    adapter_name,
    answering,
    case,
    make,
    read,
    right,
)

from mikas import commands as c
from mikas.errors import (
    AnswersLate,
    EchoDiffers,
    EchoOnly,
    EchoTwice,
    LineNotQuiet,
    NoEcho,
    NoResponse,
    SyncLost,
    UsageError,
    WrongEchoSetting,
)
from mikas.framing import Decoder, encode
from mikas.tester import Echo, Timing
from mikas.virtual.fault_injector import LineFault
from mikas.virtual.quirks import StreamEnd

each_adapter = pytest.mark.parametrize("adapter", ADAPTERS, ids=adapter_name)


@each_adapter
def test_connecting_finds_out_whether_the_line_echoes(adapter):
    tester = Watched(adapter=adapter).connected()
    assert tester.line.echo is adapter.echo
    right(tester)


@each_adapter
def test_connecting_takes_the_echo_mode_that_is_set(adapter):
    tester = Watched(adapter=adapter).connected(echo=Echo.ON if adapter.echo else Echo.OFF)
    assert tester.line.echo is adapter.echo
    right(tester)


@pytest.mark.parametrize("version", [0x09, 0x0A, 0x00, 0x0B, 0x0D, 0x40, 0xFF])
@pytest.mark.parametrize("adapter", ADAPTERS, ids=adapter_name)
def test_an_unknown_model_is_usable(version, adapter):
    tester = Watched(adapter=adapter, version=version).connected()
    assert tester.version_code == version
    right(tester)


def test_a_version_of_01_is_none_but_the_request_a_second_time():
    """Of an unknown model any byte but `01` (D1): an echo that comes twice looks like it."""
    unit = Watched(version=0x01)
    with pytest.raises(EchoTwice) as caught:
        unit.tester().connect()
    assert caught.value.request == caught.value.received == encode(b"\x01")
    link = ScriptedLink(lambda sent: [(0.0, sent), (0.0, sent)], echo=False)
    with pytest.raises(EchoTwice):
        make(link).connect()


@pytest.mark.parametrize("raw", [False, True])
@pytest.mark.parametrize("version", [0xC0, 0xF3])  # whose checksums are 40 and 0D
def test_a_unit_that_sends_its_checksum_raw_is_read(raw, version):
    unit = Watched(version=version, raw_checksum=raw)
    right(unit.connected(raw_checksum=raw))


@pytest.mark.parametrize("echo", list(Echo))
def test_an_adapter_without_12_v_gives_no_echo(echo):
    unit = Watched(adapter=DEAD)
    with pytest.raises(NoEcho) as caught:
        unit.tester(echo=echo).connect()
    assert caught.value.received == b""
    assert unit.link.now() < 3


@pytest.mark.parametrize("echo", [Echo.AUTO, Echo.ON])
def test_with_the_ignition_off_there_is_only_the_echo(echo):
    unit = Watched()
    unit.car.on = False
    with pytest.raises(EchoOnly) as caught:
        unit.tester(echo=echo).connect()
    assert caught.value.received == encode(b"\x01")
    assert unit.link.now() < 3


def test_an_echo_on_a_line_set_to_no_echo_is_no_version_code():
    unit = Watched()
    unit.car.on = False
    with pytest.raises(EchoOnly) as caught:
        unit.tester(echo=Echo.OFF).connect()
    assert caught.value.request == caught.value.received == encode(b"\x01")
    assert caught.value.time == unit.link.now()


def test_with_the_ignition_off_and_no_echo_there_is_nothing():
    unit = Watched(adapter=SILENT_ADAPTER)
    unit.car.on = False
    with pytest.raises(NoEcho):
        unit.tester().connect()


def test_connecting_succeeds_once_the_ignition_is_on():
    unit = Watched()
    unit.car.on = False
    tester = unit.tester()
    with pytest.raises(EchoOnly):
        tester.connect()
    unit.car.on = True
    tester.connect()
    right(tester)


@pytest.mark.parametrize(
    ("adapter", "echo", "problem"),
    [
        (SILENT_ADAPTER, Echo.ON, "does not return what it sends"),
        (ECHOING, Echo.OFF, "The request came back before the response"),
    ],
    ids=["on", "off"],
)
def test_the_wrong_echo_setting_has_its_own_error(adapter, echo, problem):
    unit = Watched(adapter=adapter)
    with pytest.raises(WrongEchoSetting, match=problem) as caught:
        unit.tester(echo=echo).connect()
    sent, response = encode(b"\x01"), encode(b"\x0a")
    assert caught.value.request == sent
    assert caught.value.received == (sent + response if adapter.echo else response)
    assert caught.value.time == unit.link.now()


@each_adapter
@pytest.mark.parametrize(("delay", "wanted"), [(0.55, 1.0), (0.7, 1.0), (0.95, 1.5)])
def test_a_unit_slower_than_the_time_out_is_named_with_a_time_out_that_suffices(
    adapter, delay, wanted
):
    unit = Watched(adapter=adapter, turn_round=delay)
    with pytest.raises(AnswersLate) as caught:
        unit.tester().connect()
    assert caught.value.fields["seconds"] == pytest.approx(delay, abs=0.02)
    assert caught.value.fields["wanted"] == wanted
    assert caught.value.request == encode(b"\x01")
    assert caught.value.received
    right(unit.connected(timing=Timing(response_timeout=wanted)))


def test_two_late_responses_are_not_a_slow_unit():
    own = encode(bytes([VERSION]))
    with pytest.raises(SyncLost):
        make(ScriptedLink(lambda sent: [(0.6, own), (0.62, own)])).connect()


@pytest.mark.parametrize("delays", [[0], [0.0001, 0.004]])
def test_an_emulator_without_a_wire_may_answer_before_a_wire_carries_the_request(delays):
    """Seconds from the write to the response, in turn: another program behind a socket."""
    pauses = itertools.cycle(delays)

    def answer(sent):
        (frame,) = Decoder().feed(sent)
        body = b"\x0a" if frame.body == b"\x01" else b"".join(map(DATA.get, frame.body[1:]))
        return [(next(pauses) - len(sent) * link.byte_time, encode(body))]

    link = ScriptedLink(answer, echo=False)
    tester = make(link)
    tester.connect()
    for _ in range(10):
        right(tester)
    assert tester.statistics.failed == 0
    assert not tester.line.echo


@pytest.mark.parametrize(
    "echoed", [b"\x11\xef\x1d", b"\x02\xff\x0d", b"\x00\x0d", b"\x0d"], ids=bytes.hex
)
def test_an_echo_that_always_differs_is_an_error(echoed):
    """It is no version code either."""
    link = ScriptedLink(lambda sent: [(0.0, echoed)], echo=False)
    with pytest.raises(EchoDiffers) as caught:
        make(link).connect()
    assert caught.value.request == encode(b"\x01")
    assert caught.value.received == echoed
    assert caught.value.time == link.now()


def test_a_single_spoilt_echo_is_not_the_end():
    unit = Watched(fault_injector=Fate([(LineFault.ECHO, 0), (None, 0)]))
    right(unit.connected())


@each_adapter
@pytest.mark.parametrize("line_fault", list(LineFault))
def test_connecting_survives_one_line_fault(line_fault, adapter):
    for healthy in range(3):
        with case(healthy):
            fates = [(None, 0.0)] * healthy + [(line_fault, 0.7)]
            tester = Watched(fault_injector=Fate(fates), adapter=adapter).connected()
            assert tester.line.echo is adapter.echo
            right(tester)


@each_adapter
@pytest.mark.parametrize("noise", [b"\x00", b"\r", b"\x40", b"?\x55\xaa", bytes(range(40))])
def test_noise_before_connecting_is_let_pass(noise, adapter):
    unit = Watched(adapter=adapter)
    unit.bus.unit.transmit(noise, 0.0)
    right(unit.connected())


@each_adapter
@pytest.mark.parametrize("datum", [b"\x0a", b"\x09", b"\x55", b"\x12\x34"])
def test_a_late_answer_to_an_earlier_program_is_no_version_code(datum, adapter):
    for after in (0.005, 0.05, 0.07, 0.1, 0.13, 0.2, 0.27, 0.35, 0.5, 0.7):
        with case(after):
            unit = Watched(adapter=adapter)
            unit.bus.unit.transmit(encode(datum), after)
            tester = unit.tester()
            assert tester.connect() == 0x0A
            assert tester.line.echo is adapter.echo
            right(tester)


def test_a_late_answer_is_no_version_code_even_if_the_first_request_is_lost():
    """The late one comes up to D14's limit after connecting began."""
    for after in (0.1 + 0.01 * i for i in range(60)):
        with case(after):
            unit = Watched(fault_injector=Fate([(None, 0)] * 3 + [(LineFault.LOST, 0)]))
            unit.bus.unit.transmit(encode(b"\x55"), min(after, 0.5))
            right(unit.connected())


@pytest.mark.parametrize("turn_round", [0.05, 0.1, 0.2, 0.3, 0.4, 0.45])
def test_a_slow_unit_is_not_read_one_answer_late(turn_round):
    """An earlier program's 01 is answered during ours, so each answer seems to be the next one."""
    for after in (0.02 + 0.04 * i for i in range(13)):
        with case(after):
            unit = Watched(turn_round=turn_round)
            unit.bus.unit.transmit(encode(b"\x0a"), after)
            right(unit.connected())


OPEN_FOR = [0.1, 0.3, 2.0]


@pytest.mark.parametrize("before", OPEN_FOR)
def test_connecting_counts_the_time_that_the_port_has_been_open(before):
    unit = Watched()
    unit.link.gather(before)
    unit.tester().connect(listening_since=0.0)
    requests = 0.34  # s, with the silence after each
    assert unit.link.now() == pytest.approx(max(0.5, before + requests), abs=0.02)


@each_adapter
@pytest.mark.parametrize("before", OPEN_FOR)
@pytest.mark.parametrize("after", [0.0, 0.15, 0.33, 0.5])
def test_a_late_answer_is_found_as_well_if_the_port_has_been_open(before, after, adapter):
    """It comes up to D14's limit after the opening."""
    unit = Watched(adapter=adapter)
    unit.bus.unit.transmit(encode(b"\x55"), after)
    unit.link.gather(before)
    tester = unit.tester()
    assert tester.connect(listening_since=0.0) == 0x0A
    right(tester)


STREAMS = [
    c.StreamCyclic((c.Datum(16, 1),)),
    c.StreamCyclic((c.Datum(16, 1), c.Datum(22, 1), c.Datum(67, 2))),
    *(c.StreamAtStroke((c.Datum(16, 1),), stroke) for stroke in range(5)),
    c.StreamAtStroke((c.Datum(22, 1), c.Datum(67, 2)), 0),
]


@each_adapter
@pytest.mark.parametrize("end", list(StreamEnd))
@pytest.mark.parametrize("rpm", [250.0, 850.0, 5200.0])
def test_a_stream_left_over_from_an_earlier_session_is_ended(end, adapter, rpm):
    for command in STREAMS:
        with case(command):
            unit = Watched(adapter=adapter, stream_end=end, rpm=rpm)
            unit.link.write(encode(command.body()))
            unit.link.read(0.3)
            tester = unit.tester()
            assert tester.connect() == 0x0A
            assert tester.line.echo is adapter.echo
            assert unit.count_of("stream-end") == 1
            assert (tester.sync.breaks > 0) >= (end is StreamEnd.BREAK)
            right(tester)
            assert unit.link.now() < 12


def test_a_line_that_never_becomes_quiet_is_an_error():
    class Babbling(ScriptedLink):
        def read(self, deadline):
            self.arrive(self._now + self.byte_time, b"\x55")
            return super().read(deadline)

    link = Babbling(lambda sent: [])
    with pytest.raises(LineNotQuiet) as caught:
        make(link).connect()
    assert caught.value.received == b"\x55" * 64  # the latest of them
    assert caught.value.time == link.now()
    assert link.breaks
    assert link.now() < 30


def test_two_units_that_answer_differently_are_not_trusted():
    codes = iter([0x0A, 0x09] * 20)
    link = ScriptedLink(lambda sent: [(0.005, encode(bytes([next(codes)])))])
    with pytest.raises(SyncLost) as caught:
        make(link).connect()
    assert caught.value.received in (b"\x0a", b"\x09")
    assert 0 < caught.value.time < link.now()


def test_an_answer_of_two_bytes_to_01_is_not_a_version():
    link = answering({b"\x01": encode(b"\x0a\x0a")})
    with pytest.raises(SyncLost) as caught:
        make(link).connect()
    assert caught.value.request == encode(b"\x01")
    assert caught.value.received == encode(b"\x0a\x0a")
    assert 0 < caught.value.time < link.now()


def test_a_response_lost_for_good_after_the_first_is_silence():
    answers = iter([encode(b"\x0a")])
    link = ScriptedLink(lambda sent: [(0.005, a) for a in answers])
    with pytest.raises((NoResponse, EchoOnly)):
        make(link).connect()


def test_nothing_goes_before_connect():
    unit = Watched()
    tester = unit.tester()
    for use in (
        lambda: tester.request(read(16)),
        lambda: tester.raw(b"\x02"),
        lambda: tester.time_echo(b"\x01"),
        lambda: tester.stream(STREAMS[0]),
    ):
        with pytest.raises(UsageError):
            use()
    assert unit.bus.bytes_carried == 0
    right(unit.connected())


@pytest.mark.parametrize("adapter", [ECHOING, SLOW], ids=adapter_name)
def test_connecting_takes_less_than_a_second(adapter):
    unit = Watched(adapter=adapter)
    unit.connected()
    assert unit.link.now() < 1
    assert unit.heard(b"\x01") == 3


def test_connecting_again_that_is_interrupted_leaves_nothing_to_trust():
    """Ctrl-C in any of its waits: the next request begins with a confirmation (D13)."""
    for at in range(1, 12):
        unit = Watched()
        link = StrikingLink(unit.bus, 0, lambda _: None)
        tester = unit.connected(link)

        def strike(_link):
            raise KeyboardInterrupt

        link.at, link.strike = link.operations + at, strike
        with pytest.raises(KeyboardInterrupt):
            tester.connect()
        right(tester)
        assert tester.sync.found_again == 1


def test_closing_closes_the_link_twice_over():
    unit = Watched()
    tester = unit.connected()
    tester.close()
    tester.close()
    with pytest.raises(ConnectionError):
        tester.request(read(16))
