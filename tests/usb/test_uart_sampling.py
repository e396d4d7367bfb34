"""What a UART reads of a line at its own rate and form, and at another one."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from usb.book_rig import Far
from usb.chips.uart import (
    Character,
    Damage,
    Form,
    Receiver,
    Settings,
    Uart,
    levels_of,
    sampled,
)

FORMS = [Form(bits, parity, stop) for bits in (7, 8) for parity in "NEOMS" for stop in (1, 2)]
RATES = (4800, 9600, 10400, 38400)


def values(characters):
    return bytes(it.value for it in characters)


@given(st.binary(max_size=20), st.sampled_from(FORMS), st.floats(0.97, 1.03))
def test_the_samples_of_a_line_at_its_own_rate_are_its_characters(data, form, offset):
    """Sampled in truth, without the shortcut for settings that fit."""
    sent, read = Settings(9600, form), Settings(9600 * offset, form)
    data = bytes(it & (1 << form.bits) - 1 for it in data)
    levels = [level for it in data for level in levels_of(it, form)]
    assert list(Receiver(levels, sent.rate, read)) == [Character(it) for it in data]
    assert sampled(data, sent, read) == [Character(it) for it in data]


@given(st.binary(min_size=1, max_size=40), st.sampled_from(RATES), st.sampled_from(RATES))
def test_other_rates_read_about_as_many_characters_as_the_time_has_room_for(data, sent, read):
    found = sampled(data, Settings(sent), Settings(read))
    assert len(found) <= len(data) * read / sent + 1


@pytest.mark.parametrize(("sent", "read"), [(9600, 4800), (9600, 10400), (9600, 14400)])
def test_a_wrong_rate_damages_an_exchange(sent, read):
    data = bytes.fromhex("61 29 76 0D 03 48 B6 0D")
    found = sampled(data, Settings(sent), Settings(read))
    assert values(found) != data


def test_a_rate_one_tenth_off_is_seen_as_framing_errors():
    found = sampled(b"\x00\x7f\x00\x7f", Settings(9600), Settings(10560))
    assert any(Damage.FRAMING in it.damage for it in found)


def test_zero_at_a_tenth_of_the_rate_is_a_break():
    [found] = sampled(b"\x00", Settings(960), Settings(9600))
    assert found == (0, Damage.BREAK | Damage.FRAMING)


def test_another_parity_is_a_parity_error_and_none_reads_the_parity_bit_as_stop():
    assert [it.damage for it in sampled(b"\x01", Settings(form=Form(8, "E")), _form("O"))] == [
        Damage.PARITY
    ]
    assert values(sampled(b"\x55\xaa", _form("N"), Settings(form=Form(7, "M")))) == b"\x55\x2a"


def _form(parity):
    return Settings(form=Form(8, parity))


def test_a_full_buffer_loses_what_comes_and_marks_the_last_character():
    uart = Uart(Far(), 4)
    uart.set(9600, Form())
    seen = []
    uart.heard = seen.append
    uart.hear(b"123456", Settings())
    assert (uart.lost, seen) == (2, [Damage.OVERRUN])
    found = uart.take(10)
    assert values(found) == b"1234"
    assert [it.damage for it in found] == [Damage.NONE] * 3 + [Damage.OVERRUN]


def test_nothing_is_heard_before_a_rate_is_set_and_nothing_sent_in_a_break():
    far = Far()
    uart = Uart(far, 4)
    uart.hear(b"1", Settings())
    uart.send(b"1")
    uart.set(9600, Form())
    uart.hold(True)
    uart.send(b"2")
    uart.hold(False)
    uart.send(b"3")
    assert (len(uart), far.data, far.breaks) == (0, b"3", [True, False])
    assert uart.log == ["9600 8N1", "break on", "break off"]


def test_the_first_bytes_after_opening_can_be_lost_in_both_directions():
    far = Far()
    uart = Uart(far, 4)
    uart.set(9600, Form())
    uart.lose(sent=1, received=2)
    uart.send(b"ab")
    uart.hear(b"x", Settings())
    uart.hear(b"yz", Settings())
    assert (far.data, values(uart.take(4))) == (b"b", b"z")
