"""What a logic analyser sees of the virtual unit's wire, as files that sigrok reads.

`Tap` notes every byte that either end puts on the wire, with its time, and every break; `Signal` is
the level of one channel in samples: idle high, 10 bits a byte, of two talkers the lower one (D2).
"""

from __future__ import annotations

import zipfile

import numpy as np

BITS = 10  # start, 8 data bits, stop


class Tap:
    """Watches a `Bus`. `sent`, `received`: (start, value) by the tester's view; `breaks`."""

    def __init__(self, bus):
        self.bit = bus.byte_time / BITS
        self.sent, self.received, self.breaks = [], [], []
        self._bus = bus
        self._deliver, self._deliver_rest = bus._deliver, bus._deliver_rest  # noqa: SLF001
        self._send_break = bus.send_break
        bus._deliver, bus._deliver_rest = self._delivered, self._rest_delivered  # noqa: SLF001
        bus.send_break = self._broken

    def _delivered(self, transmitter, other):
        self._note(transmitter, transmitter.queue[0])
        self._deliver(transmitter, other)

    def _rest_delivered(self, until):
        for byte in self._bus.unit.queue:
            if byte.end <= until:
                self._note(self._bus.unit, byte)
        self._deliver_rest(until)

    def _note(self, transmitter, byte):
        noted = self.sent if transmitter is self._bus.tester else self.received
        noted.append((byte.start, byte.value))

    def _broken(self, seconds, now):
        for transmitter in (self._bus.tester, self._bus.unit):
            for byte in transmitter.queue:
                if byte.start < now:  # the beginning of a byte was on the wire
                    self._note(transmitter, byte)
        self._send_break(seconds, now)
        self.breaks.append((now, now + seconds))

    @property
    def begin(self):
        return min(start for start, _ in self.sent + self.received)

    @property
    def end(self):
        ends = [start + BITS * self.bit for start, _ in self.sent + self.received]
        return max(ends + [end for _, end in self.breaks])


class Signal:
    """One channel at `rate` samples a second from `begin` on, for `seconds`."""

    def __init__(self, rate, begin, seconds):
        self.rate, self.begin = rate, begin
        self.levels = np.ones(int(seconds * rate) + 1, np.uint8)

    def number(self, time):
        """Return the first sample at or behind a time, within the signal."""
        number = int(np.ceil((time - self.begin) * self.rate))
        return min(max(number, 0), len(self.levels))

    def low(self, begin, end):
        self.levels[self.number(begin) : self.number(end)] = 0

    def invert(self, begin, end):
        self.levels[self.number(begin) : max(self.number(end), self.number(begin) + 1)] ^= 1

    def byte(self, start, value, bit):
        """Put a byte on the wire, whose bits last `bit` seconds."""
        bits = value << 1 | 1 << (BITS - 1)
        for number in range(BITS):
            if not bits >> number & 1:
                self.low(start + number * bit, start + (number + 1) * bit)


def signals(tap, rate, *, wires=1, echo=True, baud_error=0.0, margin=0.02):
    """Return the K-Line, or with two `wires` the adapter's RX (with the echo or not) and TX.

    `baud_error`: by how much both ends are too fast; a byte starts when it did.
    """
    begin, seconds = tap.begin - margin, tap.end - tap.begin + 2 * margin
    made = [Signal(rate, begin, seconds) for _ in range(wires)]
    bit = tap.bit / (1 + baud_error)
    line, sending = made[0], made[-1]
    for start, value in tap.received:
        line.byte(start, value, bit)
    for start, value in tap.sent:
        sending.byte(start, value, bit)
        if wires == 2 and echo:
            line.byte(start, value, bit)
    for low, high in tap.breaks:
        line.low(low, high)
    return made


def write_binary(path, made):
    """Write a byte a sample, channel 0 in bit 0; return sigrok-cli's arguments."""
    samples = sum(signal.levels << number for number, signal in enumerate(made))
    path.write_bytes(samples.astype(np.uint8).tobytes())
    rate = made[0].rate
    return ["-I", f"binary:numchannels={len(made)}:samplerate={rate}", "-i", str(path)]


def write_vcd(path, made):
    """Write the changes, in samples of a microsecond: sigrok-cli computes each unit of time."""
    assert made[0].rate == 1_000_000
    names = '!"#$'
    lines = ["$timescale 1 us $end", "$scope module line $end"]
    lines += [f"$var wire 1 {names[n]} D{n} $end" for n in range(len(made))]
    lines += ["$upscope $end", "$enddefinitions $end", "#0"]
    lines += [f"{signal.levels[0]}{names[n]}" for n, signal in enumerate(made)]
    changes = {}
    for number, signal in enumerate(made):
        for place in np.flatnonzero(np.diff(signal.levels)) + 1:
            changes.setdefault(int(place), []).append(f"{signal.levels[place]}{names[number]}")
    for place in sorted(changes):
        lines += [f"#{place}", *changes[place]]
    lines.append(f"#{len(made[0].levels)}")
    path.write_text("\n".join(lines) + "\n", "ascii")
    return ["-I", "vcd", "-i", str(path)]


def write_session(path, made, names=("K-Line", "TX")):
    """Write sigrok's own format, which PulseView opens."""
    samples = sum(signal.levels << number for number, signal in enumerate(made))
    probes = "".join(f"probe{n + 1}={names[n]}\n" for n in range(len(made)))
    metadata = (
        "[global]\nsigrok version=0.5.2\n\n[device 1]\ncapturefile=logic-1\n"
        f"total probes={len(made)}\nsamplerate={made[0].rate} Hz\ntotal analog=0\n"
        f"{probes}unitsize=1\n"
    )
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("version", "2")
        file.writestr("metadata", metadata)
        file.writestr("logic-1-1", samples.astype(np.uint8).tobytes())
    return ["-i", str(path)]


FORMATS = {"bin": write_binary, "vcd": write_vcd, "sr": write_session}
