"""Bytes of one wire to messages: checksum, byte stuffing, terminator (§2).

The rules are those of `mikas.framing`, and a test holds both equal. In addition, each byte knows
where it stands in the samples, a byte without a stop bit makes its message damaged, and a message
that is damaged is searched for a whole one behind a pause: the terminator of the first may be lost.
"""

TERMINATOR = 0x0D
ESCAPE = 0x40
RAW_TERMINATOR_SUM = 0xF3  # all but a raw checksum 0D has been summed (D3)
LONGEST = 4096  # bytes without a terminator
SILENCE = 0.25  # s, behind which an unfinished message is abandoned; longer than D14's 200 ms


class Byte(object):
    """A byte on the wire. `ss`, `es`: its first sample and the one behind it; `sound`: it had a
    stop bit; `pause`: seconds of silence before it.
    """

    def __init__(self, value, ss, es, sound=True, pause=0.0):
        self.value = value
        self.ss = ss
        self.es = es
        self.sound = sound
        self.pause = pause


class WireMessage(object):
    """A frame, or damage, which has a `reason` and no body.

    `wire`: its bytes, a frame's with the terminator. `places`: of each byte of the body, its first
    sample and the one behind it. `pause`: seconds of silence before it.
    """

    def __init__(self, wire, reason=None, plain=None, raw_checksum=False, irregular=False):
        self.wire = wire
        self.reason = reason
        self.body = None if plain is None else bytes(value for value, _, _ in plain[:-1])
        self.places = [] if plain is None else [(ss, es) for _, ss, es in plain[:-1]]
        self.raw_checksum = raw_checksum
        self.irregular = irregular
        self.ss = wire[0].ss
        self.es = wire[-1].es
        self.pause = wire[0].pause

    def data(self):
        """Return the bytes on the wire."""
        return bytes(byte.value for byte in self.wire)


def unstuffed(wire):
    """Return (value, first sample, sample behind) of each byte without stuffing, and whether an
    escape was irregular (D4). A 40 at the end stays a 40.
    """
    plain = []
    irregular = False
    position = 0
    while position < len(wire):
        first = last = wire[position]
        value = first.value
        if value == ESCAPE and position + 1 == len(wire):
            irregular = True
        elif value == ESCAPE:
            position += 1
            last = wire[position]
            irregular = irregular or last.value not in (0xCD, 0x00)
            value = (ESCAPE + last.value) & 0xFF
        plain.append((value, first.ss, last.es))
        position += 1
    return plain, irregular


class Framer(object):
    """Makes messages of the bytes of one wire, which come one by one."""

    def __init__(self):
        self._wire = []
        self._overflowed = False  # inside an over-long message, already reported
        self._held = False  # at a 0D that the next byte decides (D3)

    @property
    def begin(self):
        """The first sample of the unfinished message; None: there is none."""
        return self._wire[0].ss if self._wire else None

    def feed(self, byte):
        """Return the messages that this byte completes, at most two and a pending one before."""
        messages = self.abandon() if byte.pause > SILENCE else []
        is_end = byte.sound and byte.value == TERMINATOR
        if self._held:
            self._held = False
            wire, self._wire = self._wire, []
            if is_end:
                plain, irregular = unstuffed(wire[:-1])
                # The body ends before the first 0D, which is the checksum itself.
                plain.append((TERMINATOR, wire[-1].ss, wire[-1].es))
                return messages + [WireMessage(wire + [byte], None, plain, True, irregular)]
            messages += damaged(wire[:-1], wire[-1])
        self._wire.append(byte)
        if is_end:
            messages += self._ended()
        elif self._overflowed:
            self._wire = []
        elif len(self._wire) > LONGEST:
            wire = self._wire[:LONGEST]
            messages.append(WireMessage(wire, reason_of(wire, "too long")))
            self._wire = []
            self._overflowed = True
        return messages

    def left(self):
        """Return the unfinished message as damage; None: there is none."""
        wire = self._wire
        return WireMessage(wire, reason_of(wire, "unfinished")) if wire else None

    def abandon(self):
        """Return the unfinished message as damage, if there is one, and forget it."""
        wire, held, left = self._wire, self._held, self.left()
        self._wire, self._held, self._overflowed = [], False, False
        if held:
            return damaged(wire[:-1], wire[-1])
        return [left] if left else []

    def drop(self, ss):
        """Forget the last byte if it began at this sample: it was the beginning of a break."""
        if self._wire and self._wire[-1].ss == ss:
            self._wire.pop()

    def _ended(self):
        """Return the messages that a terminator ends; the last of the bytes is that one."""
        wire, end = self._wire[:-1], self._wire[-1]
        if self._overflowed or not wire:  # D5: a bare terminator is noise
            self._wire, self._overflowed = [], False
            return []
        if is_whole(wire):
            self._wire = []
            return parted(wire, end)
        found = damaged(wire, end)
        self._held = summed(wire) == RAW_TERMINATOR_SUM and found[-1].reason == "checksum"
        if self._held:
            return []
        self._wire = []
        return found


def summed(wire):
    """Return the sum of the bytes, carries dropped (§2.1)."""
    return sum(byte.value for byte in wire) & 0xFF


def is_whole(wire):
    """Return whether the bytes before a terminator are a frame."""
    return bool(wire) and summed(wire) == 0 and all(byte.sound for byte in wire)


def frame(wire, end):
    """Return the frame of whole bytes and their terminator."""
    plain, irregular = unstuffed(wire)
    # A lone 40 at the end is a raw checksum (D3); in `40 40` the first escapes the second.
    raw = wire[-1].value == ESCAPE and plain[-1][0] == ESCAPE
    if raw:
        irregular = unstuffed(wire[:-1])[1]
    return WireMessage(wire + [end], None, plain, raw, irregular)


def silence(wire, position):
    """Return the samples between a byte and the one before it."""
    return wire[position].ss - wire[position - 1].es


def is_pause(wire, position):
    """Return whether two bits' time is between a byte and the one before it."""
    byte = wire[position]
    return 5 * silence(wire, position) > byte.es - byte.ss


def parted(wire, end):
    """Return a whole frame, or the second of two, of which the first has lost its terminator.

    Each sums up to nothing, so both do. Only a pause that is longer than any other parts them.
    """
    longest = sorted(range(1, len(wire)), key=lambda position: silence(wire, position))[-2:]
    if longest and is_pause(wire, longest[-1]):
        position = longest[-1]
        alone = len(longest) == 1 or silence(wire, position) > 2 * silence(wire, longest[0])
        if alone and is_whole(wire[:position]) and is_whole(wire[position:]):
            return [WireMessage(wire[:position], "unfinished"), frame(wire[position:], end)]
    return [frame(wire, end)]


def damaged(wire, end):
    """Return the damage, and the whole frame at its end if it stands behind a pause."""
    for position in range(1, len(wire)):
        if is_pause(wire, position) and is_whole(wire[position:]):
            return [WireMessage(wire[:position], "unfinished"), frame(wire[position:], end)]
    return [WireMessage(wire, reason_of(wire, "checksum"))]


def reason_of(wire, otherwise):
    """Return why bytes are damage: a byte without its stop bit is worse than `otherwise`."""
    return otherwise if all(byte.sound for byte in wire) else "stop bit"
