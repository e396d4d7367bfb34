"""Captures frame by frame: echo, answers, damage, and real sessions with a virtual unit."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas import commands as c
from mikas import tester as tester_module
from mikas.catalog import shipped
from mikas.framing import encode
from mikas.i18n import Text
from mikas.link.base import CaptureTee, Direction
from mikas.link.virtual import VirtualLink
from mikas.recording.capture.reader import CaptureReader, Packet, Problem, Source
from mikas.recording.capture.writer import CaptureWriter
from mikas.recording.exchanges.scalar import UNFINISHED, DecodedDamage, DecodedFrame
from mikas.recording.inspect import Describer, decode, to_json, to_text
from mikas.virtual.bus import AdapterKind
from virtual_harness import make_bus

SENT, RECEIVED = Direction.SENT, Direction.RECEIVED


def packets(*lines, source=None):
    """Packets from lines like `> 01FF0D` and `< 0AF60D`, 10 ms apart; `+0.3` waits."""
    now, made = 0.0, []
    for line in lines:
        if line.startswith("+"):
            now += float(line)
            continue
        direction = SENT if line[0] == ">" else RECEIVED
        now += 0.01
        data = bytes.fromhex(line[1:])
        made.append(Packet(direction, data, now, 100 * len(made), source=source or Source(0)))
    return made


def brief(items):
    """`> 01`, `= 01` for an echo, `< 0A to 01`, `<? 0A late`, `<! 0A` for damage."""
    lines = []
    for item in items:
        sign = "=" if item.echo else ">" if item.direction is SENT else "<"
        if isinstance(item, DecodedDamage):
            lines.append(f"{sign}! {item.data.hex().upper()} {item.reason}")
            continue
        line = f"{sign} {item.frame.body.hex().upper()}"
        if item.request is not None:
            line += f" to {item.request.hex().upper()}"
        if item.doubt is not None:
            line = line.replace("<", "<?") + f" {item.doubt.name}"
        lines.append(line)
    return lines


def described(*lines):
    return brief(decode(packets(*lines)))


def frame(body):
    return encode(bytes.fromhex(body)).hex()


# The echo (D1)


def test_an_echo_and_its_answer_in_one_chunk_are_told_apart():
    assert described("> 01FF0D", "< 01FF0D0AF60D") == ["> 01", "= 01", "< 0A to 01"]


def test_without_echo_the_answer_follows_its_request():
    assert described("> 01FF0D", "< 0AF60D") == ["> 01", "< 0A to 01"]


def test_an_answer_that_looks_like_its_request_is_an_echo_and_ends_the_exchange():
    ask, other = frame("1111"), frame("1112")
    line = [f"> {ask}", f"< {ask}{ask}", f"> {other}", f"< {other}{frame('1205')}"]
    shown = ["> 1111", "= 1111", "= 1111", "> 1112", "= 1112", "< 1205 to 1112"]
    assert described(*line) == shown


def test_what_repeats_its_request_is_an_echo_also_where_the_line_has_none():
    """It may be the response; but where `01` was misjudged, it would give a value to `61 3F`."""
    ask, other = frame("1111"), frame("613F")
    lines = described("> 01FF0D", "< 0AF60D", f"> {ask}", f"< {ask}", f"> {other}", "< 7A13730D")
    assert lines[3:] == ["= 1111", "> 613F", "< 7A13 to 613F"]
    lines = described("> 01FF0D", "< 0AF60D", f"> {other}", f"< {other}", "< 7A13730D")
    assert lines[3:] == ["= 613F", "< 7A13 to 613F"]


def test_the_echo_that_was_found_late_is_believed():
    lines = described("> 01FF0D", "< 09F70D", "< 01FF0D", "< 0AF60D", "> 60A00D", "< 60A00D")
    assert lines[2:] == ["= 01", "<? 0A FAILED", "> 60", "= 60"]


def test_a_missing_echo_is_not_found_later():
    ask = frame("1111")
    assert described(f"> {ask}", "< 0D", "> 60A00D", f"< {ask}") == [
        "> 1111",
        "> 60",
        "<? 1111 NOT_IN_SYNC",
    ]


def test_what_was_sent_in_pieces_comes_back_as_a_whole():
    assert described("> 01", "> FF0D", "< 01FF", "< 0D0A", "< F60D") == [
        "> 01",
        "= 01",
        "< 0A to 01",
    ]


def test_damage_comes_back_too():
    assert described("> 01FE0D", "< 01FE0D") == [">! 01FE checksum", "=! 01FE checksum"]


def test_several_requests_in_a_row_have_their_echoes():
    assert described("> 01FF0D", "> 60A00D", "< 01FF0D", "< 60A00D", "< 15EB0D") == [
        "> 01",
        "> 60",
        "= 01",
        "= 60",
        "<? 15 FAILED",
    ]


def test_what_comes_in_place_of_the_echo_is_nobodys():
    data = frame("7D")
    lines = described(
        "> 01FF0D", "< 01FF0D", "< 0AF60D", f"> {frame('711A')}", f"< {frame('711A')}",
        f"< {data}", "> 01FF0D", f"< {data}", "< 01FF0D", "< 0AF60D",
    )  # fmt: skip
    assert lines[5:] == ["< 7D to 711A", "> 01", "<? 7D NO_ECHO", "= 01", "<? 0A FAILED"]


def test_behind_a_spoilt_echo_nothing_counts():
    lines = described("> 01FF0D", "< 01FF0D", "< 0AF60D", "> 60A00D", "< 60A10D", "< 15EB0D")
    assert lines[4:] == ["<! 60A1 checksum", "<? 15 FAILED"]


# Unfinished frames


def test_what_was_given_up_does_not_swallow_the_next_frame():
    assert described("> 01FF0D", "< 01FF0D0A", "+0.1", "> 01FF0D", "< 01FF0D") == [
        "> 01",
        "= 01",
        "> 01",
        "<! 0A unfinished",
        "= 01",
    ]


def test_a_frame_in_two_lumps_over_what_was_sent_stays_whole():
    assert described("> 711A75" + "0D", "< 7D", "> 01FF0D", "< 830D")[-1] == "< 7D to 01"


def test_silence_alone_ends_a_frame_too():
    assert described("< 7D", "+0.2", "< 830D") == ["<? 7D NO_REQUEST"]
    assert described("< 7D", "+0.3", "< 830D") == ["<! 7D unfinished", "<! 83 checksum"]


def test_the_end_of_the_file_ends_every_frame():
    assert described("> 01", "< 0A") == [">! 01 unfinished", "<! 0A unfinished"]


def test_a_raw_checksum_at_the_end_of_the_file_is_damage():
    assert described("< F30D") == ["<! F3 checksum"]


def test_a_new_recording_begins_afresh():
    first = packets("> 01FF0D", "< 0A")
    second = packets("< 0AF60D", source=Source(1))
    assert brief(decode(first + second)) == [
        "> 01",
        "<! 0A unfinished",
        "<? 0A NO_REQUEST",
    ]


def test_two_ports_do_not_mix():
    mixed = []
    for pair in zip(
        packets("> 01FF0D", "< 0A", "< F60D", source=Source(0, "a")),
        packets("> 60A00D", "< 15", "< EB0D", source=Source(0, "b")),
        strict=True,
    ):
        mixed += pair
    assert brief(decode(mixed)) == ["> 01", "> 60", "< 0A to 01", "< 15 to 60"]


def test_endless_noise_is_damage_once():
    noise = [Packet(RECEIVED, b"\x55" * 1000, n * 1.04, n) for n in range(50)]
    (damage,) = decode(noise)
    assert damage.reason == "too long"
    assert (damage.begin, damage.end) == (0.0, 4 * 1.04)


# Times, names, meanings


def test_times_and_place_are_those_of_the_first_and_last_byte():
    _, _, answer = decode(packets("> 01FF0D", "< 01FF0D0A", "< F6", "< 0D"))
    assert (answer.begin, answer.end, answer.offset) == pytest.approx((0.02, 0.04, 100))


def test_a_request_has_the_name_of_its_command():
    names = [item.name for item in decode(packets("> 01FF0D", f"> {frame('611A')}", "> 99670D"))]
    assert names == [c.Availability.SOURCE_NAME, "CREADP", None]


def test_a_message_with_an_empty_body_has_no_name():
    (item,) = decode(packets("> 000D"))
    assert (item.frame.body, item.name) == (b"", None)
    assert to_text(item).endswith("> —")


def test_requests_and_responses_are_described_and_echo_is_not():
    asked = []

    def describe(request, response):
        asked.append((request, response))
        return None if response is None else Text("Mikas 7.1", "Микас 7.1")

    items = list(decode(packets("< 00000D", "> 01FF0D", "< 01FF0D", "< 0AF60D"), lambda: describe))
    assert asked == [(b"\x01", None), (b"\x01", b"\x0a")]
    assert items[-1].meaning == Text("Mikas 7.1", "Микас 7.1")
    assert "Микас 7.1" in to_text(items[-1], "ru")
    assert to_json(items[-1])["meaning"] == {"en": "Mikas 7.1", "ru": "Микас 7.1"}


@pytest.mark.parametrize(
    ("between", "is_known"),
    [
        (["> 6429730C"], False),  # a damaged 64, and no echo that says so
        ([f"> {frame('6429')[:-2]}0C", f"< {frame('6429')}"], False),
        (["> 639C0D", f"< {frame('63')}", f"< {frame('7D')}"], True),  # too short for a 64
        (["> 639D0C", f"< {frame('63')}", f"< {frame('7D')}"], True),  # its echo is that of a 63
        (["> 6429720D", f"< {frame('6429')}", f"< {frame('00')}"], False),
        ([None], False),  # a part is missing
    ],
)
def test_a_list_is_not_known_behind_what_may_have_been_another_one(between, is_known):
    ask = [f"> {frame('63')}", f"< {frame('63')}", f"< {frame('7D')}"]
    begin = [
        *("> 01FF0D", "< 01FF0D", "< 0AF60D"),
        *(f"> {frame('641A')}", f"< {frame('641A')}", f"< {frame('00')}"),
    ]
    lines = [*begin, *ask, *(line or "" for line in between), "+0.3", *ask]
    made = packets(*filter(None, lines))
    if None in between:
        made.insert(len(begin) + len(ask), Problem(7, Text("broken", "сломано")))
    items = list(decode(made, lambda: Describer(shipped())))
    meanings = [getattr(item, "meaning", None) for item in items]
    assert meanings[8].en == "TWAT=85°C"
    assert (meanings[-1] is not None) == is_known


@pytest.mark.parametrize("other", [Source(1), Source(0, "b")], ids=["recording", "port"])
def test_a_list_belongs_to_the_line_on_which_it_was_set(other):
    one = packets(f"> {frame('641A')}", f"< {frame('00')}", f"> {frame('63')}", f"< {frame('7D')}")
    two = packets(f"> {frame('63')}", f"< {frame('7D')}", source=other)
    items = list(decode(one + two, lambda: Describer(shipped())))
    assert [item.meaning and item.meaning.en for item in items[-4:]] == [
        "read the list", "TWAT=85°C", None, None,
    ]  # fmt: skip


def test_problems_pass_through():
    problem = Problem(7, Text("broken", "сломано"))
    first, *_ = decode([problem, *packets("> 01FF0D")])
    assert first is problem
    assert to_json(problem) == {
        "schema": 1,
        "type": "problem",
        "offset": 7,
        "text": {"en": "broken", "ru": "сломано"},
    }
    assert to_text(problem, "ru") == "             ! сломано"


def test_each_item_has_its_time_place_and_port_in_json():
    source = Source(0, "sim:")
    items = list(decode(packets("> 01FF0D", "< 01FF0D0AF60D", "< 0AF70D", source=source)))
    lines = [json.loads(json.dumps(to_json(item))) for item in items]
    common = {"schema": 1, "recording": 0, "port": "sim:"}
    later = common | {"time": 0.02, "end": 0.02, "direction": "received", "offset": 100}
    plain = {"type": "frame", "raw_checksum": False, "irregular": False, "meaning": None}
    plain["doubt"] = None
    asked = plain | {"body": "01", "wire": "01FF0D", "name": "availability", "request": None}
    assert lines == [
        common
        | asked
        | {"time": 0.01, "end": 0.01, "direction": "sent", "echo": False, "offset": 0},
        later | asked | {"echo": True},
        later
        | plain
        | {"echo": False, "body": "0A", "wire": "0AF60D", "name": None, "request": "01"},
        later
        | {"type": "damage", "reason": "checksum", "data": "0AF7", "echo": False}
        | {"time": 0.03, "end": 0.03, "offset": 200},
    ]


def test_each_item_is_a_line_with_its_time_and_direction():
    lines = packets("> 01FF0D", "< 01FF0D0AF60D", "< 0AF70D", "< F30D0D", "< 411FA00D")
    assert [to_text(item, zero=0.01) for item in decode(lines)] == [
        "    0.000000 > 01  availability",
        "    0.010000 < 01  echo",
        "    0.010000 < 0A",
        "    0.020000 < ! 0A F7  wrong checksum",
        "    0.030000 < F3  not trusted: the exchange has failed; raw checksum",
        "    0.040000 < 41 1F  not trusted: the exchange has failed",
    ]
    irregular = next(decode(packets("< 4001BF0D")))
    assert irregular.frame.irregular
    assert to_text(irregular, "ru").endswith("запрос к нему неизвестен; необычная замена байта")


# Whatever the line brought


@given(
    st.lists(
        st.tuples(
            st.sampled_from(Direction),
            st.one_of(
                st.binary(max_size=8),
                st.binary(max_size=4).map(encode),
                st.sampled_from([b"\x01\xff\x0d", b"\x0a\xf6\x0d", b"\xf3\x0d", b"\x0d"]),
            ),
            st.sampled_from([0.0, 0.001, 0.03, 1.0]),
        ),
        max_size=20,
    )
)
def test_no_bytes_make_it_fail_and_none_are_shown_twice(chunks):
    now, made = 0.0, []
    for direction, data, wait in chunks:
        now += wait
        made.append(Packet(direction, data, now, len(made)))
    shown = dict.fromkeys(Direction, 0)
    for item in decode(made):
        assert item.begin <= item.end <= now
        assert made[item.offset].direction is item.direction
        data = item.frame.wire if isinstance(item, DecodedFrame) else item.data
        shown[item.direction] += len(data)
        assert item.reason in {"checksum", UNFINISHED} if isinstance(item, DecodedDamage) else True
        json.dumps(to_json(item))
        to_text(item)
    for direction in Direction:
        came = sum(len(it.data) for it in made if it.direction is direction)
        assert shown[direction] <= came


@pytest.mark.parametrize("echo", [True, False])
@pytest.mark.parametrize("latency", [0.0, 0.016])
def test_a_session_with_a_virtual_unit_is_explained_whole(tmp_path, echo, latency):
    path = tmp_path / "session.pcapng"
    bus = make_bus(adapter=AdapterKind(echo=echo, latency=latency))
    with CaptureWriter(path, url="sim:") as writer:
        tester = tester_module.Tester(CaptureTee(VirtualLink(bus), writer))
        tester.connect()
        requests = [c.ReadFaults(), c.CountParameters(), c.ReadRamByte(0x11)]
        for request in requests:
            tester.request(request)
    items = list(decode(CaptureReader(path)))
    assert all(isinstance(item, DecodedFrame) for item in items)
    sent = [item.frame.body for item in items if item.direction is SENT]
    echoed = [item.frame.body for item in items if item.echo]
    answers = [item for item in items if item.direction is RECEIVED and not item.echo]
    assert echoed == (sent if echo else [])
    assert [item.request for item in answers] == sent
    assert sent[-3:] == [request.body() for request in requests]
    for request, answer in zip(requests, answers[-3:], strict=True):
        request.read(answer.frame.body)
