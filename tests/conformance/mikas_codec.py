"""The codec of mikas, or a wrong one, as a program for `conformance/run.py`.

python mikas_codec.py [MISTAKE]
"""

from __future__ import annotations

import sys
import time

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
    if MISTAKE == "cuts-at-0d":
        ended = b"".join(chunks).split(b"\x0d")
        return " ; ".join(f"frame {hex_of(each[:-1])}".strip() for each in ended if each)
    decoder, said = Decoder(), []
    for chunk in chunks:
        if MISTAKE == "forgets-chunks":
            decoder = Decoder()
        for event in decoder.feed(chunk):
            if isinstance(event, Frame):
                said.append(f"frame {hex_of(event.body)}".strip())
            elif isinstance(event, Damage) and MISTAKE != "hides-damage":
                said.append(f"damaged {hex_of(event.data.removesuffix(bytes([13])))}".strip())
    if decoder.pending and MISTAKE != "hides-rest":
        said.append(f"left {hex_of(decoder.pending)}")
    return " ; ".join(said)


for line in sys.stdin:
    word, _, rest = line.strip().partition(" ")
    if MISTAKE == "ends":
        break
    if MISTAKE == "hangs":
        time.sleep(600)
    if word == "decode":
        print(decoded([bytes.fromhex(chunk) for chunk in rest.split("|")]), flush=True)
    else:
        print(hex_of(encoded(bytes.fromhex(rest), raw=word == "encode-raw")), flush=True)
