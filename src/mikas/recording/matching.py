"""What is an echo, and which request a response answers (D1, D13): the rules, one event at a time.

On a line that echoes, what was received holds what was sent as well: the first frame that repeats a
sent one byte for byte is its echo. An answer can look like that too (`11 11` may be answered
`11 11`), so the availability request, which is not answered with itself, settles whether the line
echoes at all. A response carries neither its command nor an id: what is no echo counts as the
answer to the last request before it.

`mikas.recording.decode` goes by these rules frame by frame; `mikas.recording.bulk` does so where it
must, and where all is regular it does in one step what they would come to.
"""

from __future__ import annotations

from collections import deque
from typing import Final

from mikas.commands import COMMANDS_BY_CODE, Availability

# An unfinished frame is given up when the line was silent for so long. Adapters pass bytes on in
# lumps and networks hold them back, so D14's 20 ms count only if something was sent meanwhile: then
# the tester has given up too.
SILENCE: Final = 0.25
SILENCE_AFTER_SENDING: Final = 0.02

AVAILABILITY: Final = Availability().body()
_MOST_UNECHOED: Final = 64


class Matching:
    """One port's requests and responses. `request`: the last one; None: not known, or damaged.

    `echoes`: whether the line gives back what is sent; None: not known yet.
    """

    def __init__(self) -> None:
        self.request: bytes | None = None
        self.echoes: bool | None = None
        self._before: bytes | None = None  # the request before the last one
        self._unechoed: deque[bytes] = deque(maxlen=_MOST_UNECHOED)

    @property
    def settled(self) -> bool:
        """Whether, until something is sent, nothing can be an echo or change this state."""
        if self.echoes or self.request != AVAILABILITY:
            return self.echoes is False or not self._unechoed
        return False

    @property
    def answered(self) -> bytes | None:
        """What a response that comes now answers."""
        # Before the echo has come, it can't be the answer to what was just sent.
        return self._before if self.echoes and self._unechoed else self.request

    def turn(self) -> None:
        """Sending begins again: what has not come back by now never will."""
        self._unechoed.clear()

    def interrupt(self) -> None:
        """Something is missing from the record, perhaps a request. Of a stream's responses it is
        one among many; any other response that comes now answers nobody knows what.
        """
        command = COMMANDS_BY_CODE.get(self.request[0]) if self.request else None
        if command is None or not command.STREAM:
            self.request = None
        self._before = None

    def sent(self, wire: bytes, body: bytes | None) -> None:
        """A frame was sent, or damage, which has no `body`."""
        self._before, self.request = self.request, body
        self._unechoed.append(wire)

    def received(self, wire: bytes, body: bytes | None) -> bool:
        """A frame was received, or damage; returns whether it is an echo."""
        if body is None:
            self._before = self.request  # that may have been the echo
        came_back = wire in self._unechoed
        if self.request == AVAILABILITY and body is not None and len(body) == 1:
            if came_back:
                self.echoes = True
            elif self.echoes is None:
                self.echoes = False
        if self.echoes is False or not came_back:
            return False
        while self._unechoed.popleft() != wire:
            pass
        return True
