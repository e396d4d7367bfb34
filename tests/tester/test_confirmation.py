"""The `01` that confirms the synchronization (D13): when it is sent, and how often it is tried."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import pytest
from stream_cases import each_stream
from tester_rig import (
    DATA,
    VERSION,
    ScriptedLink,
    Watched,
    make,
    read,
    right,
)

from mikas import commands as c
from mikas.errors import EchoOnly, LineError, NoEcho, NotSupported
from mikas.framing import Decoder, encode
from mikas.virtual.quirks import GROUPS

AVAILABILITY = encode(b"\x01")
OWN = encode(bytes([VERSION]))
REQUEST = encode(b"\x61\x16")
ANOTHERS = encode(b"\x09")
WRONG_CHECKSUM = b"\x0a\xf5\x0d"
SILENCE = b""
LATE = 1.0  # s from a request to the time when no response to it is due any more


class Scripted(ScriptedLink):
    """Gives `answers` in turn, then what the unit answers; keeps when each request was sent.

    An answer may be pieces, each with its delay.
    """

    def __init__(self, *, echo: bool = True) -> None:
        super().__init__(self._next, echo=echo)
        self.answers: Iterator[bytes | list[tuple[float, bytes]]] = iter(())
        self.times: list[float] = []

    def _next(self, sent: bytes) -> list[tuple[float, bytes]]:
        self.times.append(self.now())
        right = OWN if sent == AVAILABILITY else encode(DATA[22])
        answer = next(self.answers, right)
        return [(0.005, answer)] if isinstance(answer, bytes) else answer


def connected(*, echo: bool = True, retries: int = 0):
    link = Scripted(echo=echo)
    tester = make(link, retries=retries, pause=0.0)  # none is looked for: the requests are counted
    tester.connect()
    right(tester, 22)
    return link, tester


@pytest.mark.parametrize(
    ("damage", "at_once"),
    [
        (b"\x55\xaa\x0d", True),  # a whole frame: nothing else is due
        (b"\x55", False),  # cut: it may be another request's
        (b"\x55\xab\x0d\x55\xab\x0d", False),  # one of them is
        (encode(b"\x55\x55"), False),
        (SILENCE, False),
    ],
    ids=["checksum", "cut", "doubled", "length", "silence"],
)
def test_a_confirmation_waits_while_a_response_may_be_under_way(damage, at_once):
    link, tester = connected()
    for count in (1, 2):
        first = len(link.sent)
        link.answers = iter([damage])
        with pytest.raises(LineError):
            tester.request(read(22))
        # Only after silence it is sent at once: is there still a unit?
        assert (link.sent[first:] == [REQUEST]) == (damage != SILENCE)
        right(tester, 22)
        assert link.sent[first:] == [REQUEST, AVAILABILITY, REQUEST]
        waited = link.times[first + 1] - link.times[first]
        assert (waited < 0.3) == at_once
        assert at_once or waited >= LATE
        assert tester.sync.found_again == count


@pytest.mark.parametrize("echo", [True, False])
@pytest.mark.parametrize(
    "between", [ANOTHERS, WRONG_CHECKSUM, OWN + OWN, b"\x0a"], ids=lambda wire: wire.hex()
)
def test_only_two_silences_in_a_row_mean_that_no_unit_is_there(echo, between):
    link, tester = connected(echo=echo, retries=1)
    link.answers = iter([SILENCE, SILENCE, between, SILENCE])
    right(tester, 22)
    assert link.sent[-6:] == [REQUEST, *[AVAILABILITY] * 4, REQUEST]
    assert tester.sync.found_again == 1
    assert tester.line.silences == 1


@pytest.mark.parametrize("after", [OWN, ANOTHERS, b"\x00"], ids=lambda wire: wire.hex())
def test_a_confirmation_counts_only_if_nothing_follows_it(after):
    """One of the two answers an earlier request."""
    link, tester = connected(retries=1)
    link.answers = iter([SILENCE, [(0.005, OWN), (0.04, after)]])
    right(tester, 22)
    assert link.sent[-4:] == [REQUEST, AVAILABILITY, AVAILABILITY, REQUEST]


def test_after_a_damaged_one_the_next_follows_at_once():
    link, tester = connected(retries=1)
    link.answers = iter([b"\x55\xaa\x0d", WRONG_CHECKSUM])
    right(tester, 22)
    assert link.now() - link.times[-4] < 0.3


def test_after_an_unknown_command_the_next_request_needs_no_other():
    unit = Watched(missing=GROUPS["count"])
    tester = unit.connected()
    with pytest.raises(NotSupported):
        tester.request(c.CountParameters())
    confirmed = unit.heard(b"\x01")
    right(tester)
    assert unit.heard(b"\x01") == confirmed
    assert tester.sync.found_again == 2


@each_stream
def test_after_a_stream_the_next_request_needs_no_confirmation(command):
    unit = Watched()
    tester = unit.connected()
    with tester.stream(command) as stream:
        next(stream)
    confirmed = unit.heard(b"\x01")
    right(tester)
    assert unit.heard(b"\x01") == confirmed
    assert tester.sync.found_again == 1


@pytest.mark.parametrize("echo", [True, False])
def test_the_error_for_two_silences_says_what_was_sent_and_received(echo):
    link, tester = connected(echo=echo)
    link.answers = itertools.repeat(SILENCE)
    with pytest.raises(EchoOnly if echo else NoEcho) as caught:
        tester.request(read(22))
    assert caught.value.request == AVAILABILITY
    assert caught.value.received == (AVAILABILITY if echo else b"")
    assert caught.value.time == link.now()


def test_a_confirmation_follows_what_came_unasked_while_the_application_waited():
    link, tester = connected()
    sent = len(link.sent)
    link.arrive(link.now() + 0.03, OWN)
    tester.wait(link.now() + 0.1)
    right(tester, 22)
    assert link.sent[sent:] == [AVAILABILITY, REQUEST]


def test_ctrl_c_while_the_line_is_awaited_quiet_does_not_replace_it():
    """Bytes that no request caused have been read, and their reason is not known yet."""

    link, tester = connected()
    read_line, sent = link.read, len(link.sent)
    link.arrive(link.now(), OWN)

    def strike(_deadline):
        raise KeyboardInterrupt

    def take(deadline):
        link.read = strike
        return read_line(deadline)

    link.read = take
    with pytest.raises(KeyboardInterrupt):
        tester.request(read(22))
    link.read = read_line
    right(tester, 22)
    assert link.sent[sent:] == [AVAILABILITY, REQUEST]


def test_an_emulator_that_answers_at_once_only_now_and_then_is_believed_again():
    """Too soon for a wire, after responses that were not: one failure, and one confirmation."""
    delays = itertools.chain([0.0] * 4, [0.006] * 20, itertools.repeat(0.0))

    def answer(sent):
        (frame,) = Decoder().feed(sent)
        body = b"\x0a" if frame.body == b"\x01" else b"".join(map(DATA.get, frame.body[1:]))
        return [(next(delays) - len(sent) * link.byte_time, encode(body))]

    link = ScriptedLink(answer, echo=False)
    tester = make(link)
    tester.connect()
    for _ in range(10):
        right(tester)
    assert (tester.statistics.failed, tester.sync.found_again) == (1, 1)
