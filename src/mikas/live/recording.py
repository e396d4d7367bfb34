"""`Ecu.record`: a recording of all that a unit is asked, by whatever methods.

    with ecu.record("drive.pcapng") as recording:
        ecu.read("TWAT")
        recording.mark("warm")

The file is as those of `mikas log`: bytes and times of each exchange, the unit's identity, marks.
"""

from __future__ import annotations

import builtins
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from mikas.client.connecting import StrPath
from mikas.client.identity import UnitIdentity
from mikas.client.recorded import EcuRecording
from mikas.errors import CaptureError
from mikas.link.base import CaptureTee, Direction, Link, LinkWrapper
from mikas.live.record_failures import RecordFailures
from mikas.recording.recorder import Recorder, RecordingStatus
from mikas.sampling.supervisor import unit_found

if TYPE_CHECKING:
    from mikas.client import Ecu


class LineRecording(EcuRecording):
    """A recording of one `Ecu`, from here to `close`; of several at a time each is whole.

    `on_failure` gets the error of a file that can't be written any more, and the unit's requests go
    on unrecorded; without it the error is raised by the request that meets it, and by each later
    one, or by `close`. Raises `CaptureError` if the file exists or can't be made, and what reading
    the passports raises: a session reads them once, and the file has them.
    """

    def __init__(
        self,
        ecu: Ecu,
        path: StrPath,
        *,
        on_failure: Callable[[CaptureError], object] | None = None,
    ) -> None:
        self._ecu = ecu
        self._failures = RecordFailures(on_failure)
        self._recorder = Recorder()
        self._status: RecordingStatus | None = None  # of the file that is closed
        self._tee: CaptureTee | None = None
        tester = ecu.tester
        self._recorder.start(Path(path), url=tester.link.url)
        try:
            tester.wrap_link(self._teed)
            unit = UnitIdentity(ecu.version_code, ecu.passport())
            self._recorder.record_event(unit_found(ecu, unit))
        except BaseException:
            self._leave()
            self._recorder.discard()
            raise

    @property
    def _progress(self) -> RecordingStatus:
        status = self._recorder.status or self._status
        assert status is not None
        return status

    @property
    def path(self) -> Path:
        return self._progress.path

    @property
    def bytes(self) -> int:
        return self._progress.bytes

    @property
    def failure(self) -> CaptureError | None:
        return self._progress.failure

    def mark(self, label: str = "") -> float | None:
        return self._recorder.marker(self._ecu.tester.link.now(), label)

    def note(self, text: str) -> None:
        self._recorder.text(text)

    def close(self) -> None:
        if self._status is None:
            self._leave()
            self._status = self._recorder.stop()
            self._failures.report(self.failure)

    def record(self, direction: Direction, data: builtins.bytes, time: float) -> None:
        """Take bytes that passed on the wire; of `mikas.link.base.Sink`."""
        self._recorder.record(direction, data, time)
        self._failures.report(self._recorder.failure, again=True)

    def _teed(self, link: Link) -> CaptureTee:
        self._tee = CaptureTee(link, self, on_failure=_raise)
        return self._tee

    def _leave(self) -> None:
        """Take the tee out of the chain of links; a message on the line just now may be cut."""
        tester, tee = self._ecu.tester, self._tee
        if tee is None:
            return
        if tester.link is tee:
            tester.link = tester.line.link = tee.link
            return
        outer = tester.link  # of a recording that was begun later
        while isinstance(outer, LinkWrapper):
            if outer.link is tee:
                outer.link = tee.link
                return
            outer = outer.link


def _raise(error: Exception) -> None:
    raise error
