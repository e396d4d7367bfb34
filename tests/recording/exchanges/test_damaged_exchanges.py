"""What a damaged line or file shows is right or absent: named after what was once invented (D13).

`make fuzz` has the same sessions, checks and many more changes (fuzz/exchanges).
"""

from __future__ import annotations

import pytest
from fuzz.exchanges import inventions
from fuzz.exchanges.campaign import findings
from fuzz.exchanges.cases import Case, case
from fuzz.exchanges.lines import file_of
from fuzz.exchanges.readers import READERS, expected
from fuzz.exchanges.sessions import METHODS, Packet, session

from mikas.framing import encode
from mikas.virtual.bus import AdapterKind

FEW = ("TWAT", "UACC", "INJ")
OTHERS = ("UACC", "TWAT", "INJ")  # data of the same sizes
COLUMNS = [it for it in READERS if it.name in ("columns", "turns", "table")]


def rows_of(path, made, line, *, every=True):
    """The rows with values; none is invented, and all readers have the same."""
    one = Case(0, (tuple(line),), (made.packets,), {(0, 0): made.truth}, ())
    path.write_bytes(file_of(one.sections))
    found = expected(path)
    inventions.check(one, found)
    for reader in COLUMNS if every else ():
        reader.compare(path, found)
    return [row for _, row in found.rows if row]


def flips(line, *, sent):
    """The line with each bit of each packet of a direction flipped, one at a time."""
    for at, it in enumerate(line):
        for bit in range(8 * len(it.data)) if it.sent is sent else ():
            data = bytearray(it.data)
            data[bit // 8] ^= 1 << bit % 8
            yield [*line[:at], it._replace(data=bytes(data)), *line[at + 1 :]]


def places(line, begin):
    return [at for at, it in enumerate(line) if it.sent and it.data.startswith(begin)]


def test_noise_in_an_echo_gives_no_value_to_the_request_before(tmp_path):
    made = session((("single", FEW, 2),))
    line = list(made.packets)
    sound = len(rows_of(tmp_path / "it.pcapng", made, line))
    for at in places(line, b"\x02"):
        echo = line[at + 1]
        for noise in (b"\x00", b"\x00\x0d", b"\x00\x00\x0d", b"\x7d\x83\x0d"):
            for place in range(len(line[at].data)):
                spoilt = echo._replace(data=echo.data[:place] + noise + echo.data[place:])
                rows = rows_of(
                    tmp_path / "it.pcapng", made, [*line[: at + 1], spoilt, *line[at + 2 :]]
                )
                assert len(rows) <= sound


@pytest.mark.parametrize("sent", [True, False])
@pytest.mark.parametrize("echo", [True, False])
@pytest.mark.parametrize("method", METHODS)
def test_a_flipped_bit_of_a_packet_invents_nothing(tmp_path, method, echo, sent):
    made = session(((method, FEW[:2], 2),), AdapterKind(echo=echo))
    assert rows_of(tmp_path / "it.pcapng", made, made.packets)
    for number, line in enumerate(flips(list(made.packets), sent=sent)):
        if number % 21 == 0:  # every bit of a byte, in turn
            rows_of(tmp_path / "it.pcapng", made, line, every=number % 210 == 0)


def test_a_lone_01_with_a_damaged_echo_does_not_make_a_line_one_without_echo(tmp_path):
    made = session((("batch", FEW, 3),))
    line = list(made.packets)
    line = line[places(line, b"\x01")[-1] :]
    assert rows_of(tmp_path / "it.pcapng", made, line)
    for damaged in (b"\x01\xff", b"\x01\xfe\x0d", b"\x01\xff\x0c", b"\x0d", b""):
        spoilt = line[1]._replace(data=damaged + line[1].data[3:])
        rows_of(tmp_path / "it.pcapng", made, [line[0], spoilt, *line[2:]])


def test_a_list_whose_setting_lost_its_echo_names_nothing(tmp_path):
    made = session((("list", FEW, 3),))
    line = list(made.packets)
    (at,) = places(line, b"\x64")
    assert rows_of(tmp_path / "it.pcapng", made, line)
    assert not rows_of(tmp_path / "it.pcapng", made, [*line[: at + 1], *line[at + 2 :]])


@pytest.mark.parametrize("echo", [True, False])
def test_a_list_is_not_known_behind_a_damaged_or_missing_request(tmp_path, echo):
    made = session((("list", FEW, 2), ("list", OTHERS, 2)), AdapterKind(echo=echo))
    line = list(made.packets)
    _, second = places(line, b"\x64")
    half = len(rows_of(tmp_path / "it.pcapng", made, line)) // 2
    damaged = line[second]._replace(data=line[second].data[:1] + b"\x1b" + line[second].data[2:])
    gone = line[second]._replace(data=b"", missing=True)
    behind = places(line, b"\x63")[-2]
    for changed in (
        [*line[:second], damaged, *line[second + 1 :]],
        [*line[:second], gone, *line[behind:]],
    ):
        assert len(rows_of(tmp_path / "it.pcapng", made, changed)) == half


def exchange(time, request, response, *, echo=True):
    """The packets of one exchange, with bodies in hex."""
    wire, answer = (encode(bytes.fromhex(it)) for it in (request, response))
    return [
        Packet(True, wire, time, 0),
        *[Packet(False, wire, time + 0.01, 0)] * echo,
        Packet(False, answer, time + 0.04, 0),
    ]


def values_of(path, line):
    """The rows with values, which all readers have."""
    path.write_bytes(file_of([line]))
    found = expected(path)
    for reader in COLUMNS:
        reader.compare(path, found)
    return [row for _, row in found.rows if row]


def bytes_lost(wire):
    """What remains of a packet that lost some bytes."""
    for mask in range(1 << len(wire)):
        yield bytes(it for at, it in enumerate(wire) if mask >> at & 1)


@pytest.mark.parametrize("echo", [True, False])
@pytest.mark.parametrize("codes", ["29", "292C"])
def test_a_list_is_not_known_behind_one_whose_request_lost_bytes(tmp_path, echo, codes):
    """Of a 64 with one code that lost a byte, as much remains as of a 63: the list counted on."""
    data = "1A1B"[: len(codes)]
    new, *rest = exchange(1000.3, f"64{codes}", "00", echo=echo)
    behind = exchange(1000.8, "01", "0A", echo=echo) + exchange(1001.0, "63", data, echo=echo)
    before = [
        *exchange(1000.0, "01", "0A", echo=echo),
        *exchange(1000.1, "64" + "1A29"[: len(codes)], "00", echo=echo),
        *exchange(1000.2, "63", data, echo=echo),
    ]
    assert len(values_of(tmp_path / "it.pcapng", [*before, *behind])) == 2
    for left in bytes_lost(new.data):
        if left == new.data:
            continue
        line = [*before, new._replace(data=left), *rest, *behind]
        assert len(values_of(tmp_path / "it.pcapng", line)) == 1, left.hex(" ")


@pytest.mark.parametrize("echo", [True, False])
def test_a_list_is_not_known_behind_one_whose_request_is_missing(tmp_path, echo):
    """Its echo, or its response, is all that shows it."""
    lists = session((("list", FEW, 2), ("list", OTHERS, 2)), AdapterKind(echo=echo))
    _, *rest = exchange(1000.3, "64292C", "00", echo=echo)
    before = [
        *exchange(1000.0, "01", "0A", echo=echo),
        *exchange(1000.1, "641A29", "00", echo=echo),
        *exchange(1000.2, "63", "1A1B", echo=echo),
    ]
    behind = [
        *exchange(1000.8, "01", "0A", echo=echo),
        *exchange(1001.0, "63", "1A1B", echo=echo),
        *exchange(1001.2, "63", "1A1B", echo=echo),
    ]
    assert len(values_of(tmp_path / "it.pcapng", [*before, *behind])) == 3
    for left in (rest, rest[:1], rest[-1:]):
        assert len(values_of(tmp_path / "it.pcapng", [*before, *left, *behind])) == 1
    line = list(lists.packets)
    _, second = places(line, b"\x64")
    half = len(rows_of(tmp_path / "it.pcapng", lists, line)) // 2
    assert (
        len(rows_of(tmp_path / "it.pcapng", lists, [*line[:second], *line[second + 1 :]])) <= half
    )


@pytest.mark.parametrize("early", [0, 2, 3, 4])
@pytest.mark.parametrize("packets", [1, 2, 4])
def test_without_echo_a_response_in_one_packet_began_before_its_end(tmp_path, early, packets):
    """It counted as begun when its packet came: a response that the tester had refused (D2)."""
    line = [
        *exchange(1000.0, "01", "0A", echo=False),
        *exchange(1000.1, "611A29", "1A1B", echo=False),
        *exchange(1000.2, "611A29", "1A1B", echo=False),
    ]
    asked, response = line[-2:]
    byte = 10 / 9600
    out = asked.time + len(asked.data) * byte  # the request's last byte
    first = out + byte * (1 - early / 2)  # when the response's first byte has come
    size = len(response.data) // packets
    ends = [*range(size, len(response.data), size), len(response.data)][-packets:]
    pieces = [
        response._replace(data=response.data[start:end], time=first + (end - 1) * byte)
        for start, end in zip([0, *ends], ends, strict=False)
    ]
    assert b"".join(it.data for it in pieces) == response.data
    counts = not early
    assert len(values_of(tmp_path / "it.pcapng", [*line[:-1], *pieces])) == 1 + counts


@pytest.mark.parametrize("piece", range(4))
def test_without_echo_any_packet_of_a_response_that_came_too_soon_refuses_it(tmp_path, piece):
    """The columns looked at the first packet's time alone, whatever the times of the others."""
    line = [
        *exchange(1000.0, "01", "0A", echo=False),
        *exchange(1000.1, "611A29", "1A1B", echo=False),
        *exchange(1000.2, "611A29", "1A1B", echo=False),
        *exchange(1000.3, "611A29", "1A1B", echo=False),
        *exchange(1000.4, "01", "0A", echo=False),
    ]
    response = line[5]
    byte = 10 / 9600
    pieces = [
        response._replace(data=bytes((it,)), time=response.time + at * byte)
        for at, it in enumerate(response.data)
    ]
    assert len(values_of(tmp_path / "it.pcapng", [*line[:5], *pieces, *line[6:]])) == 3
    pieces[piece] = pieces[piece]._replace(time=pieces[piece].time - 0.04)
    assert len(values_of(tmp_path / "it.pcapng", [*line[:5], *pieces, *line[6:]])) == 1


@pytest.mark.parametrize("copies", [1, 2])
@pytest.mark.parametrize("method", METHODS)
def test_a_second_echo_is_no_response(tmp_path, method, copies):
    """One of `61 3F` was INJ 129.8 ms."""
    made = session(((method, FEW[-1:], 3),))
    line = list(made.packets)
    for at in range(1, len(line)):
        if line[at - 1].sent and line[at].data.startswith(line[at - 1].data):
            more = [line[at]._replace(data=line[at - 1].data)] * copies
            rows_of(tmp_path / "it.pcapng", made, [*line[:at], *more, *line[at:]])


@pytest.mark.parametrize("number", range(12))
def test_the_fuzzers_first_cases_have_no_finding(number):
    assert not list(findings(case(1, number)))
