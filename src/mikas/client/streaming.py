"""Readings that a unit sends on its own; a stopped stream is started again (71, 7F–83; D12)."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

from mikas.catalog import Parameter
from mikas.client.parameters import Parameters, Reading
from mikas.commands import Availability, StreamAtStroke, StreamCyclic
from mikas.errors import (
    EngineStopped,
    LineError,
    LinkLost,
    MikasError,
    NoConnection,
    NoResponse,
    NotSupported,
)
from mikas.i18n import Text
from mikas.tester import Stream, StreamItem, Tester


class ReadingStream:
    """The stream of `wanted`; `stroke` None: the cyclic one. `close` ends it."""

    def __init__(
        self,
        tester: Tester,
        parameters: Parameters,
        wanted: Sequence[Parameter],
        stroke: int | None = None,
    ) -> None:
        self.works = False  # whether a response has ever been received
        self.silent = 0  # silences in a row, though the unit answers and could have sent
        self._tester = tester
        self._parameters = parameters
        self._wanted = tuple(wanted)
        self._stroke = stroke
        self._stream: Stream | None = None
        self._heard = 0.0

    def next(self, patience: float | None = None) -> tuple[float, dict[str, Reading]] | None:
        """Return the next response's time and readings; None after `patience` seconds without one.

        Raises `NotSupported` if the unit does not start the stream, `LinkLost`, or another
        `NoConnection` or `LineError` after which the next call may succeed: a damaged response does
        not end the stream. `NoResponse`: the unit answers, but its stream has stopped;
        `EngineStopped`: a stream by strokes without strokes.
        """
        while True:
            try:
                item = self._next(patience)
            except StopIteration:
                self._stream = None  # closed by another caller: start it again
            except NoResponse as error:
                reason = self._end() or self._why_silent(error)
                if self.works or not self.silent or reason is not error:
                    raise reason from error
                if self.silent > 1:  # the request of the first may have been lost
                    raise self._not_supported(error) from error
            except MikasError as error:
                if isinstance(error, LineError) and self._stream is not None:
                    self._heard = self._tester.link.now()  # only one response was damaged
                else:
                    self._end()
                raise
            else:
                if item is None:
                    return None
                self.works, self.silent, self._heard = True, 0, self._tester.link.now()
                return item.time, self._parameters.of_item(self._wanted, item)

    def close(self) -> None:
        """End the stream; `next` starts it again. Raises `LineNotQuiet` if that fails."""
        stream, self._stream = self._stream, None
        if stream is not None:
            with suppress(NoConnection):  # no ECU, so no stream
                stream.close()

    def _next(self, patience: float | None) -> StreamItem | None:
        if self._stream is None:
            self._stream = self._parameters.raw_stream(self._wanted, self._stroke)
            self._heard = self._tester.link.now()
        now = self._tester.link.now()
        if patience is None:
            until = deadline = max(self._heard, now) + self._stream.silence
        else:
            until = self._heard + self._stream.silence
            deadline = min(until, now + patience)
        # Until a response has fitted, one that does not fit may be a refusal of so many parameters.
        item = self._stream.read(deadline, raise_errors=self.works)
        if item is None and not self._stream.running:
            raise StopIteration
        if item is None and self._tester.link.now() >= until:
            raise self._stream.fallen_silent()
        return item

    def _end(self) -> NoConnection | None:
        """End the stream after a failure; return a `NoConnection` met by that, or None."""
        stream, self._stream = self._stream, None
        if stream is not None:
            try:
                stream.close()
            except NoConnection as error:
                return error
            except MikasError:  # the same failure, or a consequence of it
                pass
        return None

    def _why_silent(self, error: NoResponse) -> LineError | NoConnection:
        """Return the reason of a silence; count the silence if the unit could have sent."""
        try:
            self._tester.request(Availability())
            if self._stroke is None:
                self.silent += 1
                return error
            rpm = self._parameters.read(["FREQ"])["FREQ"]
        except LinkLost:
            raise
        except (LineError, NoConnection) as cause:
            return cause
        except NotSupported:
            return error
        if rpm.value:
            self.silent += 1
            return error
        self.silent = 0
        return EngineStopped(
            seconds=error.fields["seconds"],
            request=error.request,
            received=error.received,
            time=error.time,
        )

    def _not_supported(self, error: NoResponse) -> NotSupported:
        cyclic = self._stroke is None
        code = StreamCyclic.CODES[0] if cyclic else StreamAtStroke.CODES[self._stroke or 0]
        count = len(self._wanted)
        command = Text(
            f"a stream ({code:02X}) of parameters ({count})",
            f"потока ({code:02X}) с числом параметров {count}",
        )
        return NotSupported(command=command, request=error.request, received=b"", time=error.time)
