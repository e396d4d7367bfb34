"""Which responses fit a request: the tester's own check of length, address and content (D13)."""

from __future__ import annotations

from typing import Any, Final

from mikas import commands as c
from mikas.commands.base import ERROR, SizeOf
from mikas.errors import EcuRefused, MikasError
from mikas.recording.exchanges.layouts import READ_LIST

NOT_SIMPLE: Final = -1
_MOST: Final = 4096  # requests that are remembered


class Fitting:
    """The check for all requests. `size_of`: bytes of a code's datum; None: not known.

    `listed`, below: the length of the responses to 63; None: the unit's list is not known.
    """

    def __init__(self, size_of: SizeOf) -> None:
        self._size_of = size_of
        self._known: dict[bytes, c.Command[Any] | None] = {}

    def fits(self, request: bytes, body: bytes, listed: int | None) -> bool:
        """Return whether `body` may answer `request`; a refusal may, and all may a request that is
        not known.
        """
        if request == READ_LIST:
            return listed is None or len(body) == listed or body == ERROR
        command = self._command(request)
        if command is None:
            return True
        try:
            command.read(body)
        except EcuRefused:
            return True
        except MikasError:
            return False
        return True

    def length(self, request: bytes, listed: int | None) -> int:
        """Return the length of the responses to a request for data, which nothing but the length
        has to fit; else `NOT_SIMPLE`.
        """
        if request == READ_LIST:
            return NOT_SIMPLE if listed is None else listed
        command = self._command(request)
        simple = isinstance(command, c.ReadParameters)
        return command.response_lengths()[0] if simple and command is not None else NOT_SIMPLE

    def list_length(self, request: bytes) -> int | None:
        """Return the length of the responses to 63 behind this 64."""
        command = self._command(request)
        if not isinstance(command, c.WriteList):
            return None
        return sum(datum.size for datum in command.parameters)

    def _command(self, request: bytes) -> c.Command[Any] | None:
        if request not in self._known:
            if len(self._known) >= _MOST:
                self._known.clear()
            try:
                self._known[request] = c.parse(request, self._size_of)
            except c.MalformedRequest:
                self._known[request] = None
        return self._known[request]
