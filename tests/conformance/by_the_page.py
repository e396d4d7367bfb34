"""A tester written from docs/protocol.md alone: it knows nothing of mikas.

It needs a line with `write(bytes)`, `read(deadline)` → bytes (none: the deadline has come), `now()`
and `send_break(seconds)`. Times are the page's settings (D12–D14).
"""

from __future__ import annotations

FIRST_BYTE, BETWEEN_BYTES, QUIET, GAP = 0.5, 0.2, 0.06, 0.02
TRIES = 6
SIZES = {0x3F: 2, 0x21: 2, 0x40: 2, 0x59: 2}  # §4; all others have one byte


class Void(Exception):
    """The exchange is void; the line is to be synchronized (D13)."""


class Refused(Exception):
    """The unit answered 01, or nothing (D10, D17)."""


def message(body):
    """§2.1, §2.2, D3."""
    whole = bytes(body) + bytes([-sum(body) % 256])
    pairs = {0x0D: b"\x40\xcd", 0x40: b"\x40\x00"}
    return b"".join(pairs.get(byte, bytes([byte])) for byte in whole) + b"\x0d"


def unstuffed(part):
    plain, place = [], 0
    while place < len(part):
        byte = part[place]
        if byte == 0x40 and place + 1 < len(part):
            place += 1
            byte = (byte + part[place]) % 256
        plain.append(byte)
        place += 1
    return bytes(plain)


class Decoder:
    """§2.3."""

    def __init__(self):
        self.part = b""
        self.waits = False

    def feed(self, data):
        """Return the bodies; None for damage."""
        found = []
        for byte in data:
            if self.waits:
                self.waits = False
                found.append(unstuffed(self.part) if byte == 0x0D else None)
                self.part = b"" if byte == 0x0D else bytes([byte])
            elif byte != 0x0D:
                self.part += bytes([byte])
            elif self.part:
                total = sum(self.part) % 256
                self.waits = total == 0xF3
                if not self.waits:
                    found.append(unstuffed(self.part)[:-1] if total == 0 else None)
                    self.part = b""
        return found


class Tester:
    """§3.2 on a line."""

    def __init__(self, line):
        self.line = line
        self.echo = False
        self.version = b""

    def connect(self):
        """D1: find the echo and the version."""
        request = message(b"\x01")
        self.quiet()
        self.line.write(request)
        received = self.gather(FIRST_BYTE)
        self.echo = received.startswith(request)
        bodies = Decoder().feed(received[len(request) if self.echo else 0 :])
        if len(bodies) != 1 or bodies[0] is None or len(bodies[0]) != 1:
            raise Void
        self.version = bodies[0]
        return self.version[0]

    def gather(self, first):
        """Return the bytes until none has come for as long as a response may pause."""
        received, deadline = b"", self.line.now() + first
        while data := self.line.read(deadline):
            received += data
            deadline = self.line.now() + BETWEEN_BYTES
        return received

    def quiet(self, seconds=QUIET):
        """Wait until the line has been quiet for so long (D2); give up after a second."""
        end = self.line.now() + 1 + seconds
        while self.line.read(self.line.now() + seconds):
            if self.line.now() > end:
                return False
        return True

    def send(self, body):
        request = message(body)
        self.line.write(request)
        heard = b""
        while self.echo and len(heard) < len(request):
            data = self.line.read(self.line.now() + FIRST_BYTE)
            heard += data
            if not data or heard[: len(request)] != request[: len(heard)]:
                raise Void
        return heard[len(request) :]

    def exchange(self, body, length):
        """Return the response's body; `length`: the lengths that fit."""
        early = self.send(body)
        decoder, deadline = Decoder(), self.line.now() + FIRST_BYTE
        bodies, silent = decoder.feed(early), True
        while not bodies:
            data = self.line.read(deadline)
            if not data:
                if silent and not early:
                    raise Refused
                raise Void
            silent = False
            bodies = decoder.feed(data)
            deadline = self.line.now() + BETWEEN_BYTES
        if len(bodies) > 1 or bodies[0] is None or decoder.part:
            raise Void
        if bodies[0] == b"\x01" and (1 not in length or body[0] in (0x22, 0x24, 0x26, 0x62, 0x64)):
            raise Refused
        if len(bodies[0]) not in length:
            raise Void
        return bodies[0]

    def ask(self, body, *length):
        """An exchange; after a void one the line is synchronized, and it is tried once more."""
        for attempt in (1, 2):
            try:
                return self.exchange(bytes(body), length)
            except Void:
                self.synchronize()
                if attempt == 2:
                    raise
            except Refused:
                self.synchronize()
                raise
        raise AssertionError

    def synchronize(self):
        """D13: no late response can come any more, a quiet line, one clean `01`."""
        for _ in range(TRIES):
            self.quiet(2 * FIRST_BYTE)
            try:
                if self.exchange(b"\x01", (1,)) == self.version and self.quiet():
                    return
            except (Void, Refused):
                pass
        raise Void

    def read(self, *codes):
        """61: the data by code."""
        sizes = [SIZES.get(code, 1) for code in codes]
        return cut(self.ask([0x61, *codes], sum(sizes)), sizes)

    def read_bytes(self, code, address, count):
        """23, 25: a block, in either form of D7."""
        low_high = address.to_bytes(2, "little")
        body = self.ask([code, *low_high, count], 2 + count, 3 + count)
        if body[:2] != low_high or (len(body) == 3 + count and body[2] != count):
            raise Void
        return body[-count:]

    def faults(self):
        """02."""
        body = self.ask([0x02], *range(1, 512, 2))
        if body == b"\x01":
            raise Refused
        if body[0] != len(body) // 2 or set(body[2::2]) - {0xE0}:
            raise Void
        return list(body[1::2])

    def erase(self):
        """§3.3."""
        for last in (0x08, 0x00):
            assert self.ask([0x62, 0x0E, last], 1) == b"\x00"

    def stream(self, code, *codes, count):
        """71, 7F … 83: so many responses, then the end (D12)."""
        sizes = [SIZES.get(each, 1) for each in codes]
        decoder, rows = Decoder(), []
        data = self.send([code, *codes])
        while len(rows) < count:
            rows += [cut(body, sizes) for body in decoder.feed(data) if body is not None]
            data = self.line.read(self.line.now() + 2)
            if not data:
                raise Refused
        self.end_stream()
        return rows[:count]

    def end_stream(self):
        """D12: `01` in a gap, at last a break."""
        for attempt in range(TRIES + 1):
            if attempt == TRIES:
                self.line.send_break(0.05)
            else:
                while (data := self.line.read(self.line.now() + GAP)) and data[-1] != 0x0D:
                    pass
                self.line.write(message(b"\x01"))
            if self.quiet(2 * FIRST_BYTE):
                self.synchronize()
                return
        raise Void


def cut(body, sizes):
    data, place = [], 0
    for size in sizes:
        data.append(body[place : place + size])
        place += size
    return data
