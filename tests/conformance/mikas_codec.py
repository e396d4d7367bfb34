"""The codec of mikas, or a wrong one, as a program for `conformance/run.py`.

python mikas_codec.py [MISTAKE]
"""

from __future__ import annotations

import sys
import time

from mikas.catalog import shipped
from mikas.framing import Damage, Decoder, Frame, encode

MISTAKE = sys.argv[1] if len(sys.argv) > 1 else ""


def hex_of(data: bytes) -> str:
    return data.hex(" ").upper()


def encoded(body: bytes, *, raw: bool) -> bytes:
    if MISTAKE == "unstuffed-checksum":
        raw = True
    elif MISTAKE == "stuffed-always":
        raw = False
    wire = encode(body, raw_checksum=raw)
    if MISTAKE == "no-stuffing":
        return body + bytes([-sum(body) % 256]) + b"\x0d"
    if MISTAKE == "wrong-sum":
        return wire[:-2] + bytes([(wire[-2] + 1) % 256]) + b"\x0d"
    return wire


def decoded(chunks: list[bytes]) -> str:
    if MISTAKE == "escapes-again":  # a 40 behind a 40 begins a pair of its own
        chunks = [b"".join(chunks).replace(b"\x40\x40", b"\x40\x00\x40")]
    if MISTAKE == "cuts-at-0d":
        ended = b"".join(chunks).split(b"\x0d")
        return " ; ".join(f"frame {hex_of(each[:-1])}".strip() for each in ended if each)
    decoder, said = Decoder(limit=256) if MISTAKE == "short-buffer" else Decoder(), []
    for chunk in chunks:
        if MISTAKE == "forgets-chunks":
            decoder = Decoder()
        for event in decoder.feed(chunk):
            if isinstance(event, Frame):
                said.append(f"frame {hex_of(event.body)}".strip())
            elif isinstance(event, Damage) and MISTAKE != "hides-damage":
                said.append(f"damaged {hex_of(event.data.removesuffix(bytes([13])))}".strip())
    if decoder.pending and MISTAKE != "hides-rest":
        rest = decoder.pending
        if MISTAKE == "hides-waiting-0d":
            rest = rest.removesuffix(b"\x0d")
        said.append(f"left {hex_of(rest)}")
    return " ; ".join(said)


def value(name: str, raw: bytes) -> str:
    parameter = shipped().parameter(name)
    if MISTAKE == "messages-alone":
        return "?"
    if MISTAKE == "high-byte-first":
        raw = raw[::-1]
    if MISTAKE == "decimal-mask" and parameter.conversion.mask:
        return "yes" if raw[0] & int(f"{parameter.conversion.mask:X}") else "no"
    found = parameter.decode(raw, "literal" if MISTAKE == "literal" else "corrected")
    return ("yes" if found else "no") if isinstance(found, bool) else str(found)


for line in sys.stdin:
    word, _, rest = line.strip().partition(" ")
    if MISTAKE == "ends":
        break
    if MISTAKE == "hangs":
        time.sleep(600)  # the runner ends it by its time-out
    if word == "decode":
        print(decoded([bytes.fromhex(chunk) for chunk in rest.split("|")]), flush=True)
    elif word == "value":
        name, _, raw = rest.partition(" ")
        print(value(name, bytes.fromhex(raw)), flush=True)
    else:
        print(hex_of(encoded(bytes.fromhex(rest), raw=word == "encode-raw")), flush=True)
