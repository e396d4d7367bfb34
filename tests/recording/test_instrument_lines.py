"""`mikas decode` of instruments: a line a message, text or bytes, with the channels' values."""

from __future__ import annotations

import random
from collections.abc import Iterable
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from instrument_recording import record
from mikas.catalog import shipped
from mikas.i18n import Text
from mikas.instruments import InstrumentValues, decoder_of, definition_named, definition_of_text
from mikas.link.base import Direction
from mikas.recording import CaptureReader
from mikas.recording.capture.instruments import CONNECTED, instrument_port, loss
from mikas.recording.capture.reader import Packet, Source
from mikas.recording.inspect import decode
from mikas.recording.instrument_lines import (
    InstrumentLines,
    InstrumentMessage,
    message_json,
    message_text,
)

AEM = definition_named("aem")


def source(name: str = "aem", label: str = "") -> Source:
    port = instrument_port(definition_named(name), "/dev/meter", label)
    return Source(
        0, port.name, port.description, port.speed, definition=port.comment, instrument=True
    )


def packets(of: Source, chunks: Iterable[bytes | str]) -> list[Packet]:
    """A packet for each chunk, a second apart; a text is a comment without bytes."""
    found = []
    for at, chunk in enumerate(chunks):
        data, comment = (b"", chunk) if isinstance(chunk, str) else (chunk, "")
        found.append(Packet(Direction.RECEIVED, data, float(at), 100 + at, comment, of))
    return found


def messages(given: Iterable[Packet]) -> list[InstrumentMessage]:
    lines = InstrumentLines(shipped())
    return [each for packet in given for each in lines.feed(packet)]


def test_a_message_in_several_pieces_is_one_line() -> None:
    unplugged = loss(Text("unplugged", "отключён"))
    chunks = [CONNECTED, b"\r\n", b"14.", b"70\r\n", b"??\r\n1", unplugged, CONNECTED, b"\n1.0\r\n"]
    found = messages(packets(source(label="left"), chunks))
    assert [message_text(it) for it in found] == [
        "    0.000000 = left:aem  connected",
        "    2.998958 = left:aem  “14.70”  AFR_LEFT=14.70 LAMBDA_LEFT=1.000λ",
        "    3.997917 = left:aem  ! “??”  not understood",
        "    5.000000 = left:aem  lost: unplugged",
        "    6.000000 = left:aem  connected",
        "    6.998958 = left:aem  “1.0”  LAMBDA_LEFT=1.000λ AFR_LEFT=14.70",
    ]
    assert message_text(found[3], "ru", zero=5) == (
        "    0.000000 = left:aem  связь потеряна: отключён"
    )


def test_a_binary_instrument_has_its_bytes_in_hex() -> None:
    frame = bytes.fromhex("B2 82 43 13 03 6B")
    first, second = messages(packets(source("innovate"), [frame[:3], frame[3:] + frame]))
    assert message_text(second) == (
        "    1.000000 = innovate  B2 82 43 13 03 6B  LAMBDA=0.991λ AFR=14.57"
    )
    assert (first.data, first.text, first.values) == (frame, None, second.values)


def test_json_has_bytes_text_values_and_what_is_wrong() -> None:
    lost = loss(Text("gone", "нет"))
    chunks = [b"\r\n1.02\r\n", b"\xff\r\n", lost]
    good, bad, gone = map(message_json, messages(packets(source(), chunks)))
    assert good == {
        "schema": 1, "type": "reading", "recording": 0, "port": "/dev/meter", "instrument": "aem",
        "time": pytest.approx(-0.001042, abs=1e-6), "offset": 100,
        "data": good["data"], "text": "1.02",
        "values": {"LAMBDA": 1.02, "AFR": 14.994}, "reason": None,
    }  # fmt: skip
    assert bytes.fromhex(str(good["data"])) == b"1.02"
    assert (bad["text"], bad["values"]) == (None, {})
    assert bad["reason"] == {"en": "not understood", "ru": "не разобрано"}
    assert (gone["type"], gone["state"]) == ("instrument", "lost")
    assert gone["reason"] == {"en": "gone", "ru": "нет"}


def test_one_without_a_definition_has_its_bytes_and_the_reason_once() -> None:
    wrong = Source(0, "/dev/meter", "gone, Gone gauge", 9600, definition="x = ", instrument=True)
    first, second = messages(packets(wrong, [b"12\r\n", b"13\r\n"]))
    assert message_text(first).startswith("    0.000000 = gone  ! “12”  ")
    assert "gone.toml" in message_text(first)
    assert message_text(second).endswith("without a definition")


@given(
    st.lists(st.sampled_from([b"14.7\r\n", b"0.98\r\n", b"\xb2\x80", b"no\n", b"\r\n", b""])),
    st.integers(0, 999),
)
def test_values_are_those_of_the_decoder_however_the_bytes_are_cut(
    parts: list[bytes], seed: int
) -> None:
    whole = b"\r\n" + b"".join(parts)
    plain = [it.values for it in decoder_of(AEM).feed(whole) if isinstance(it, InstrumentValues)]
    rng = random.Random(seed)
    cuts = sorted(rng.randrange(len(whole) + 1) for _ in range(5))
    pieces = [whole[a:b] for a, b in zip([0, *cuts], [*cuts, len(whole)], strict=True)]
    found = messages(packets(source(), [piece for piece in pieces if piece]))
    assert [it.values for it in found if it.values] == plain
    joined = b"".join(it.data for it in found)
    assert len(joined) <= len(whole)
    for it in found:
        assert message_json(it)["data"] == it.data.hex().upper()
        assert "\n" not in message_text(it)


@given(st.lists(st.binary(max_size=40), max_size=20), st.sampled_from(["aem", "innovate", "nmea"]))
def test_no_bytes_make_it_raise(chunks: list[bytes], name: str) -> None:
    for it in messages(packets(source(name), [*chunks, b"x" * 9000])):
        assert message_text(it, "ru")
        assert len(it.data) <= 4096


def test_the_units_frames_are_the_same_beside_an_instrument(tmp_path: Path) -> None:
    said = [(0, [(0, b"\r\n", 0.0, ""), (1, b"\n", 0.0, "")])]
    said += [(at, [(0, b"14.7\r\n", 0.0, ""), (1, b"99 kPa\n", 0.0, "")]) for at in range(1, 20)]
    own = definition_of_text(
        "own",
        'text = "Manometer"\ndecoder = "line"\npatterns = ["{PRESSURE} kPa"]\n'
        '[instrument.PRESSURE]\ntext = "Pressure"\nunit = "kPa"\n',
    )
    both = record(tmp_path / "a.pcapng", said, (("aem", ""), (own, "")), count=20)
    alone = [it for it in decode(CaptureReader(both)) if not isinstance(it, Packet)]
    lines, found, frames = InstrumentLines(shipped()), [], []
    for item in decode(CaptureReader(both).with_other_protocols(instruments=True)):
        if isinstance(item, Packet):
            found += lines.feed(item)
        else:
            frames.append(item)
    assert frames == alone
    assert len(frames) > 20
    names = {it.name: it.values for it in found if it.values}
    assert names["own"] == {"PRESSURE": 99.0}
    assert names["aem"]["AFR"] == 14.7
