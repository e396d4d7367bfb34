"""Recordings for decoders outside Python: hostile lines at random, and sessions of the tester.

Each is a section; joined end to end they are one file, which a decoder reads in one go.
"""

from __future__ import annotations

import json
from contextlib import suppress
from dataclasses import replace
from functools import partial
from itertools import islice
from pathlib import Path
from random import Random

from mikas import connect
from mikas.client import Ecu
from mikas.errors import MikasError
from mikas.framing import encode, stuff
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.writer import CaptureWriter

OUTBOUND, INBOUND = pcapng.OUTBOUND, pcapng.INBOUND
VECTORS = Path(__file__).parents[2] / "conformance"
CODES = (0x1A, 0x29, 0x2C, 0x26, 0x1E, 0x3F, 0x21, 0x40, 0x08, 0x07, 0x39, 0x42, 0x59, 0x1C)
SIZES = {0x3F: 2, 0x21: 2, 0x40: 2, 0x59: 2}


def section(packets, *interfaces: pcapng.Interface) -> bytes:
    """Return a section of blocks, or packets as (flags, data, time)."""
    described = interfaces or (pcapng.Interface(name="line", speed=9600),)
    parts = [pcapng.Section(application="mikas test"), *described]
    parts += [packet(*each) if isinstance(each, tuple) else each for each in packets]
    return b"".join(map(pcapng.encode, parts))


def packet(flags: int, data: bytes, time: float, interface: int = 0) -> pcapng.EnhancedPacket:
    return pcapng.EnhancedPacket(interface, round(time * 1e6), data, flags)


def vector_exchanges() -> list[tuple[bytes, bytes | None]]:
    listed = json.loads((VECTORS / "exchanges.json").read_text("utf-8"))
    bodies = [(each["request"], each.get("answer")) for each in listed]
    return [(bytes.fromhex(one), two and bytes.fromhex(two)) for one, two in bodies]


def vector_streams() -> list[bytes]:
    """Return the bytes of every frame and stream of the vectors."""
    return [
        bytes.fromhex(wire)
        for name in ("frames", "streams")
        for each in json.loads((VECTORS / f"{name}.json").read_text("utf-8"))
        for key in ("wire", "wire_with_raw_checksum")
        if (wire := each.get(key))
    ]


class Line:
    """One line, made up byte by byte: a tester and a unit that do anything."""

    def __init__(self, random: Random) -> None:
        self.random = random
        self.packets: list[tuple[int, bytes, float]] = []
        self.time = random.choice([0.0, 12.5, 1_700_000_000.25])
        self.echo = random.random() < 0.6
        self.chunk = random.choice(["bytes", "whole", "any"])
        self.trouble = random.choice([0.0, 0.0, 0.05, 0.3])
        self.at_once = random.random() < 0.2  # responses begin while their request is sent (D2)
        self.listed: bytes = b""
        self.exchanges = vector_exchanges()

    def section(self, steps: int = 25) -> bytes:
        self.exchange(b"\x01", b"\x0a")
        for _ in range(steps):
            self.step()
        return section(self.packets)

    def step(self) -> None:
        random, choice = self.random, self.random.random()
        for _ in range(random.choices([0, 1, 2], [8, 1, 2])[0]):
            self.exchange(
                b"\x01", random.choices([b"\x0a", b"\x09", b"\x01", None], [9, 1, 1, 1])[0]
            )
        codes = bytes(random.choices(CODES, k=random.choice([1, 1, 2, 5])))
        if choice < 0.25:
            request, answer = random.choice(self.exchanges)
            self.exchange(request, answer)
        elif choice < 0.4:
            self.exchange(b"\x61" + codes, self.data(codes))
        elif choice < 0.5:
            self.exchange(b"\x64" + codes, random.choice([b"\x00", b"\x00", b"\x01", None]))
            self.listed = codes
        elif choice < 0.65:
            self.exchange(b"\x63", self.data(self.listed))
        elif choice < 0.75:
            self.exchange(bytes([random.choice([0x71, 0x7F, 0x83])]) + codes, self.data(codes))
            for _ in range(random.randrange(5)):
                self.receive(encode(random.choice([self.data(codes), b"\x01"])))
        elif choice < 0.85:
            self.exchange(*self.memory())
        elif choice < 0.95:
            body = random.randbytes(random.randrange(5))
            self.exchange(body, random.choice([b"\x01", random.randbytes(3), None]))
        else:
            self.time += random.choice([0.02, 0.0201, 0.25, 0.26, 3.0])

    def memory(self) -> tuple[bytes, bytes]:
        random = self.random
        code = random.choice([0x11, 0x12, 0x13, 0x14, 0x21, 0x22, 0x23, 0x24, 0x25, 0x31, 0x41])
        size = 2 if code in (0x13, 0x14, 0x23, 0x24, 0x25, 0x41) else 1
        address, data = random.randbytes(size), random.randbytes(random.randrange(1, 5))
        count = bytes([len(data)])
        match code >> 4, code & 1:
            case 1 | 3, 1:
                return bytes([code]) + address, address + data[:1]
            case 1 | 3, 0:
                return bytes([code]) + address + data[:1], address + data[:1]
            case 2, 1:
                counted = random.random() < 0.5 or code == 0x21
                answer = address + (count if counted else b"") + data
                return bytes([code]) + address + count, answer
            case 2, 0:
                return bytes([code]) + address + count + data, random.choice([b"\0", b"\1", b"\2"])
        return bytes([code]) + address, data

    def data(self, codes: bytes) -> bytes:
        random = self.random
        if random.random() < 0.1:
            return random.choice([b"\x01", b"", random.randbytes(2)])
        return b"".join(
            bytes(random.choices([0x0D, 0x40, 0x01, 0xF3, *range(256)], k=SIZES.get(code, 1)))
            for code in codes
        )

    def exchange(self, request: bytes, answer: bytes | None) -> None:
        random, wire = self.random, self.wire(request)
        self.feed(OUTBOUND, wire)
        if not self.at_once:
            self.time += len(wire) / 960
        got = wire if self.echo else b""
        if random.random() < self.trouble:
            got = random.choice([self.spoilt(got), b"\x00" + got, got + b"\xff"])
        if answer is not None and random.random() < 0.95:
            response = self.wire(answer)
            if random.random() < 0.05:
                response += self.wire(random.choice([answer, b"\x7d"]))
            if random.random() < 0.5:
                got += response
            else:
                self.feed(INBOUND, got)
                got = response
                if random.random() < 0.06:
                    self.time += random.choice([0.3, 0.53, 0.7, 1.15])
        self.feed(INBOUND, got)
        if answer is not None and random.random() < 0.03:
            self.receive(self.wire(answer))

    def receive(self, wire: bytes) -> None:
        self.feed(INBOUND, wire)

    def wire(self, body: bytes) -> bytes:
        random = self.random
        wire = encode(body, raw_checksum=random.random() < 0.2)
        return self.spoilt(wire) if random.random() < self.trouble else wire

    def spoilt(self, wire: bytes) -> bytes:
        random = self.random
        at = random.randrange(len(wire) + 1)
        return random.choice([
            wire[:at],
            wire[:at] + random.randbytes(1) + wire[at:],
            wire[:at] + b"\r" + wire[at:],
            wire[:at] + b"\x40" + wire[at:],
            wire[:at] + wire[at + 1 :],
            b"\r\r" + wire,
            stuff(random.randbytes(3)) + b"\xf3\r",
            random.choices([wire, bytes(4200)], [9, 1])[0],
        ])  # fmt: skip

    def feed(self, flags: int, wire: bytes) -> None:
        random, at = self.random, 0
        while at < len(wire):
            size = {"bytes": 1, "whole": len(wire), "any": random.randint(1, 6)}[self.chunk]
            size = max(size, len(wire) // 20)  # of 4,200 bytes, not as many packets
            piece = wire[at : at + size]
            at += size
            pauses = [0.0, 0.001, 0.003, 0.02, 0.0211, 0.2, 0.2511, -0.5]
            self.time += len(piece) / 960 + random.choices(pauses, [60, 60, 9, 3, 3, 3, 1, 1])[0]
            self.time = max(self.time, 0.0)
            self.packets.append((flags, piece, round(self.time, 6)))


def hostile(seeds) -> bytes:
    """Return a file with a section of a random line for each seed."""
    return b"".join(Line(Random(seed)).section() for seed in seeds)


def vectors() -> bytes:
    """Return the vectors' bytes, received once in chunks and once byte by byte."""
    whole = [(INBOUND, wire, at / 10) for at, wire in enumerate(vector_streams())]
    single = [
        (INBOUND, bytes([byte]), at / 10 + place / 960)
        for at, wire in enumerate(vector_streams())
        for place, byte in enumerate(wire)
    ]
    return section(whole) + section(single)


def crafted() -> bytes:
    """Return sections with what a file may have beside whole packets of one port.

    The ports are in the first: Wireshark 4.0 names those of a later one wrongly.
    """
    one, two = (pcapng.Interface(name=name, speed=9600) for name in ("a", "b"))
    earlier = replace(one, tsoffset=-1)
    request, answer = encode(b"\x61\x1a"), encode(b"\x7d")
    mixed = [
        packet(flags, data, 1 + at / 1000, port)
        for at, (flags, data) in enumerate([(OUTBOUND, encode(b"\x01")), (INBOUND, encode(b"\x0a")),
                                            (OUTBOUND, request), (INBOUND, answer)])
        for port in (0, 2)
    ]  # fmt: skip
    below_zero = [  # the same port as 0
        packet(OUTBOUND, request[:2], 2.99, 1),
        packet(OUTBOUND, request[2:], 2.0, 0),
        packet(INBOUND, answer, 2.5, 0),
    ]
    no_direction = [
        (OUTBOUND, request, 1.0), (0, b"\x01", 1.1), (INBOUND, answer, 1.2),
        (OUTBOUND, encode(b"\x71\x1a"), 2.0), (3, answer, 2.1), (INBOUND, answer, 2.2),
    ]  # fmt: skip
    cut = pcapng.EnhancedPacket(0, 1_100_000, answer[:1], INBOUND, cut=2)
    is_cut = [(OUTBOUND, request, 1.0), cut, (INBOUND, answer, 1.2), (OUTBOUND, request, 1.3)]
    every_kind = [  # flags, a stored fault, an irregular escape, a response of another length,
        # a refusal, an unknown request, damage of each reason
        (OUTBOUND, encode(b"\x61\x07"), 1.0), (INBOUND, encode(b"\x24"), 1.1),
        (OUTBOUND, encode(b"\x02"), 1.2), (INBOUND, encode(b"\x01\x0d\xe0"), 1.3),
        (INBOUND, b"\x40\x01\xbf\r", 1.4), (INBOUND, encode(b"\x01\x02"), 1.5),
        (OUTBOUND, encode(b"\x64\x1a"), 1.6), (INBOUND, encode(b"\x01"), 1.7),
        (OUTBOUND, encode(b"\x99"), 1.8), (INBOUND, b"\x01\x02\r", 1.9),
        (INBOUND, b"\x15", 2.0), (INBOUND, b"\x15" * 4100 + b"\r", 6.6),
    ]  # fmt: skip
    list_set = [(OUTBOUND, encode(b"\x64\x1a"), 1.0), (INBOUND, encode(b"\0"), 1.1)]
    list_unknown = [(OUTBOUND, encode(b"\x64\x55"), 1.2), (INBOUND, encode(b"\0"), 1.3)]
    list_read = [(OUTBOUND, encode(b"\x63"), 2.0), (INBOUND, answer, 2.1)]
    return (
        section(mixed + below_zero, one, earlier, two)
        + section(no_direction)
        + section(is_cut)
        + section(every_kind)
        + section(list_set + list_read)
        + section(list_set + list_unknown + list_read)
        + section(list_read)
    )


# Settings of the virtual unit, and the methods by which it is read.
SETTINGS = (
    "",
    "&model=5.4&faults=13,53,99&raw_checksum=1&latency_ms=16&counted_blocks=1",
    "&echo=0&damaged=0.1&noise=0.1&unknown=01&missing=bytes",
    "&echo=0&late=0.05&doubled=0.05&noise=0.03",
    "&late=0.1&latency_ms=16&noise=0.05",
    "&missing-byte=0.1&cut=0.1&doubled=0.1&foreign=0.1&bad-echo=0.05&lost=0.05&late=0.05",
)
METHODS = ("single", "batch", "list", "stream", "stroke0", "stroke3")
NAMES = ("TWAT", "FREQ", "JAIR", "RXX", "BITPOW", "DET", "UOZ", "INJ", "RCOK", "UACC")


def sessions_of_program(folder: Path) -> bytes:
    """Return the recordings of the program itself: all it can do, on sound and troubled lines."""
    recorded = []
    for number, settings in enumerate(SETTINGS):
        path = folder / f"{number}.pcapng"
        with (
            suppress(MikasError),  # on the worst lines it may not even connect
            CaptureWriter(path, url="sim:") as writer,
            connect(f"sim:?clock=simulated&seed={number}{settings}", retries=1, sink=writer,
                    confirm=lambda change: True) as ecu,
        ):  # fmt: skip
            for act in (*map(partial(partial, _watched), METHODS), *_ACTS):
                with suppress(MikasError):
                    act(ecu)
        recorded.append(path.read_bytes())
    return b"".join(recorded)


def _watched(method: str, ecu: Ecu) -> None:
    for _ in islice(ecu.watch(*NAMES, method=method), 8):
        pass


_ACTS = (
    lambda ecu: ecu.passport(again=True),
    lambda ecu: ecu.faults(),
    lambda ecu: ecu.erase_faults(),
    lambda ecu: ecu.set_list("TWAT", "INJ"),
    lambda ecu: ecu.read_list(),
    lambda ecu: ecu.write_parameter("UACC", 14),
    lambda ecu: ecu.raw(bytes.fromhex("2100FF")),
    lambda ecu: ecu.raw(bytes.fromhex("23001020")),
    lambda ecu: ecu.raw(bytes.fromhex("2220020D40")),
    lambda ecu: ecu.raw(bytes.fromhex("12200D")),
    lambda ecu: ecu.raw(bytes.fromhex("410080")),
    lambda ecu: ecu.raw(bytes.fromhex("99")),
    lambda ecu: ecu.raw(bytes.fromhex("61F1")),
    lambda ecu: ecu.raw(b"\x60"),
)
