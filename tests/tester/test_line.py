"""One request out, one response in: how long the line waits (D14), what its errors carry (D1)."""

from __future__ import annotations

import pytest
from tester_rig import DATA, VERSION, ScriptedLink, make, read, right

from mikas import commands as c
from mikas.errors import DamagedResponse, EchoDiffers, LineError, MikasError, NoEcho, NoResponse
from mikas.framing import encode

REQUEST = encode(b"\x61\x16")
RESPONSE = encode(DATA[22])
OWN = encode(bytes([VERSION]))


Pieces = list[tuple[float, bytes]]


class Scripted(ScriptedLink):
    """Answers `01` and reads of 22, or once what a test says: delays behind the request's end."""

    def __init__(self, *, echo: bool) -> None:
        super().__init__(self._answer, echo=echo)
        self._echoes = echo
        self._once: Pieces | None = None

    def next_time(self, *pieces: tuple[float, bytes], echo: Pieces | None = None) -> None:
        """The next request is answered by `pieces`, and echoed by `echo` if that is given."""
        self._once = [*(echo or []), *pieces]
        self.echo = self._echoes and echo is None

    def _answer(self, sent: bytes) -> Pieces:
        pieces, self._once, self.echo = self._once, None, self._echoes
        usual = OWN if sent == encode(b"\x01") else RESPONSE
        return [(0.005, usual)] if pieces is None else pieces


def connected(*, echo: bool = True, **settings: object):
    link = Scripted(echo=echo)
    tester = make(link, **settings)
    tester.connect()
    right(tester, 22)
    return link, tester


both = pytest.mark.parametrize("echo", [True, False])


@both
def test_a_response_may_begin_half_a_second_after_the_request(echo):
    link, tester = connected(echo=echo, retries=0)
    link.next_time((0.499, RESPONSE))
    right(tester, 22)
    link.next_time((0.501, RESPONSE))
    with pytest.raises(NoResponse):
        tester.request(read(22))
    right(tester, 22)


@both
def test_a_response_may_pause_for_200_ms(echo):
    link, tester = connected(echo=echo, retries=0)
    ends = link.byte_time + 0.199
    link.next_time(
        (0.01, RESPONSE[:1]), (0.01 + ends, RESPONSE[1:2]), (0.01 + 2 * ends, RESPONSE[2:])
    )
    right(tester, 22)
    link.next_time((0.01, RESPONSE[:1]), (0.01 + link.byte_time + 0.201, RESPONSE[1:]))
    asked = link.now() + len(REQUEST) * link.byte_time
    with pytest.raises(DamagedResponse, match="ends in the middle") as caught:
        tester.request(read(22))
    assert caught.value.time == pytest.approx(asked + 0.01 + link.byte_time + 0.2)
    assert caught.value.received == RESPONSE[:1]


@both
def test_a_response_that_drips_without_end_is_given_up(echo):
    """Each byte just before the limit; twice the longest response, and five pauses, are enough."""
    link, tester = connected(echo=echo, retries=0)
    began = link.now()
    link.next_time(*((0.19 * count, b"\x55") for count in range(1, 100)))
    with pytest.raises(DamagedResponse, match="it has no end") as caught:
        tester.request(read(22))
    assert caught.value.time - began <= 0.5 + 2 * 1100 * link.byte_time + 6 * 0.21


def test_the_half_second_begins_when_the_echo_has_come():
    """The network held the echo up, and so the response."""
    link, tester = connected(retries=0)
    link.next_time((0.55, RESPONSE), echo=[(0.15, REQUEST)])
    right(tester, 22)


def test_the_half_second_does_not_begin_before_the_wire_has_carried_the_request():
    """An adapter that makes the echo itself, and a request that takes a fifth of a second."""
    link, tester = connected(retries=0)
    command = c.WriteXramBlock(0, bytes(200))
    sent = encode(command.body())
    link.next_time((0.45, encode(b"\x00")), echo=[(0.001 - len(sent) * link.byte_time, sent)])
    tester.request(command)


@pytest.mark.parametrize("echoed", [b"", REQUEST[:2], b"\x61\x17", b"\x41" + REQUEST[1:]])
def test_the_error_of_an_echo_says_what_was_sent_and_what_came(echoed):
    link, tester = connected(retries=0)
    asked = link.now() + len(REQUEST) * link.byte_time
    link.next_time(echo=[(0.0, echoed)] if echoed else [])
    with pytest.raises(EchoDiffers if echoed else NoEcho) as caught:
        tester.request(read(22))
    assert caught.value.request == REQUEST
    assert caught.value.received == echoed
    given_up = 0.0 if echoed and not REQUEST.startswith(echoed) else 0.5
    assert caught.value.time == pytest.approx(asked + given_up)
    right(tester, 22)


def test_without_an_echo_a_response_before_the_requests_end_is_none():
    """It answers something else, and it met the request on the wire (D2)."""
    link, tester = connected(echo=False, retries=0)
    link.next_time((-0.001, RESPONSE))
    with pytest.raises(DamagedResponse, match="began while the request was being sent") as caught:
        tester.request(read(22))
    assert (caught.value.request, caught.value.received) == (REQUEST, RESPONSE)
    right(tester, 22)
    assert tester.sync.found_again == 1


def test_a_responses_time_is_never_before_its_requests_end():
    """The echo and the response came in one piece, late."""
    link, tester = connected()
    link.next_time(echo=[(0.05, REQUEST + RESPONSE)])
    asked = link.now()
    reply = tester.exchange(read(22))[1]
    ended = asked + 4 * link.byte_time + 0.05
    assert reply.ended == pytest.approx(ended)
    assert reply.began == pytest.approx(ended - len(RESPONSE) * link.byte_time)


def test_an_echo_is_timed_without_the_response_in_the_same_piece():
    link, tester = connected()
    link.next_time(echo=[(0.05, encode(b"\x01") + OWN)])
    assert tester.time_echo(b"\x01") == pytest.approx(0.05)


def test_two_answers_while_the_echo_is_timed_are_not_trusted():
    link, tester = connected()
    link.next_time((0.005, OWN + OWN))
    tester.time_echo(b"\x01")
    right(tester, 22)
    assert tester.sync.found_again == 1


def test_an_echo_is_timed_whatever_the_unit_answers():
    link, tester = connected()
    tester.time_echo(b"\x01")
    right(tester, 22)
    assert tester.sync.found_again == 0  # it was answered
    link.next_time()
    assert tester.time_echo(b"\x01") == pytest.approx(3 * link.byte_time)
    right(tester, 22)
    assert tester.sync.found_again == 1


def test_two_requests_in_a_row_without_a_byte_are_a_silence():
    """The unit was off for a second, or it does not know the command."""
    link, tester = connected(retries=0)
    for _ in range(2):  # each is followed by a confirmation, which is answered
        link.next_time()
        with pytest.raises(NoResponse):
            tester.request(read(22))
    assert tester.line.silences == 0
    usual = link.answer
    for count, echo in ((1, True), (2, False)):
        link.answer, link.echo = (lambda _: []), echo
        for _ in range(3):
            with pytest.raises(MikasError):
                tester.request(read(22))
        assert tester.line.silences == count
        link.answer, link.echo = usual, True
        right(tester, 22)


@pytest.mark.parametrize(
    ("form", "wire"), [({}, "615f4000 0d"), ({"raw_checksum": True}, "615f 40 0d")]
)
def test_the_request_and_the_one_in_an_error_have_the_form_that_is_set(form, wire):
    """61 + 5F sum to C0, so the checksum is 40; it is sent stuffed by default (D3)."""
    link, tester = connected(retries=0, **form)
    link.next_time((0.005, encode(b"\x00\x00")))
    with pytest.raises(LineError) as caught:
        tester.request(c.ReadParameters((c.Datum(0x5F, 1),)))
    assert link.sent[-1] == caught.value.request == bytes.fromhex(wire)


@both
def test_bare_terminators_around_a_response_are_counted(echo):
    link, tester = connected(echo=echo)
    link.next_time((0.01, b"\x0d\x0d"), (0.02, RESPONSE))
    right(tester, 22)
    assert tester.line.noise == 2
