"""The codec alone, byte by byte: for a logic analyser's output, or a link in another program.

`mikas.framing` and `mikas.commands` open nothing, never wait and read no clock.
"""

from __future__ import annotations

from mikas.catalog import shipped
from mikas.commands import Datum, ReadParameters
from mikas.framing import Decoder, Frame, encode

coolant = shipped().parameter("TWAT")
request = ReadParameters((Datum(coolant.code, coolant.size),))
print("request", encode(request.body()).hex(" "))

# What a wire could carry: the request's echo, a damaged response, the response.
wire = encode(request.body()) + bytes.fromhex("7e 83 0d") + encode(b"\x7e")
decoder = Decoder()
for byte in wire:
    for event in decoder.feed(bytes([byte])):
        if not isinstance(event, Frame):
            print(f"at byte {event.offset}: {event.reason.value} in {event.data.hex(' ')}")
        elif event.body == request.body():
            print(f"at byte {event.offset}: the echo")
        else:
            (raw,) = request.read(event.body)  # raises WrongLength … for a response of another
            print(f"at byte {event.offset}: {coolant.name} {coolant.decode(raw)} {coolant.unit}")
