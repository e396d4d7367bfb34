"""The unit under survey: requests of any form, each with its times, on the tester's line.

Every request passes the tester, so D13 holds: after silence or damage the line is quiet and in step
before the next one. Damage is repeated; silence is an answer, and is asked for twice.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import replace
from typing import Any, ClassVar, Self

from mikas import errors
from mikas.catalog import Catalog
from mikas.client import Ecu
from mikas.client.parameters.parameters import Parameters
from mikas.commands import Availability
from mikas.commands.base import Command, MalformedRequest, SizeOf
from mikas.i18n import Text
from mikas.survey.recording import SurveyCapture
from mikas.tester import Reply, Tester
from mikas.tester.pauses import Pauses

SPEED = 0x29  # FREQ, 40 rpm a step (§4, E1)
IDLE_SPEED = 0x2C  # FREQX, 10 rpm a step
COOLANT = 0x1A  # TWAT
VOLTAGE = 0x1E  # UACC
FREQ_STEP = 40  # rpm of FREQ's raw 1
_RPM = {SPEED: FREQ_STEP, IDLE_SPEED: 10}
_LONGEST = 4096  # bytes of a body, as the decoder takes
_DAMAGED = 3  # exchanges in a row, after which a line is too bad
_ROOM = 32  # codes in a request of the survey itself, at most
_SPARE, _ROUNDED = 1.1, 0.005  # of the least pause: a factor, and s
_HASTE = 0.12  # s to a response at least, where silence is usual
_LOOKS, _PATIENCE = 3, 1.0  # for a unit that seems gone: how often, and s before each


class AnyRequest(Command[bytes]):
    """A request of any body, whose response may have any length."""

    __slots__ = ("_body",)
    CODES: ClassVar[tuple[int, ...]] = ()
    SOURCE_NAME: ClassVar[str] = "request"
    TITLE: ClassVar[Text] = Text("request", "запрос")

    def __init__(self, body: bytes) -> None:
        self._body = body

    @property
    def code(self) -> int:
        return self._body[0]

    def body(self) -> bytes:
        return self._body

    def response_lengths(self) -> Sequence[int]:
        return range(_LONGEST + 1)

    def _read(self, body: bytes) -> bytes:
        return body

    def respond(self, value: bytes) -> bytes:
        return value

    @classmethod
    def parse(cls, body: bytes, size_of: SizeOf) -> Self:
        """Raise `MalformedRequest`: it is no command of §3."""
        raise MalformedRequest


class SurveyedUnit:
    """A connected unit. `sizes`: of the codes that 61 has answered; `longest`: the most codes that
    a request of the survey itself lists.
    """

    def __init__(self, ecu: Ecu) -> None:
        self.ecu = ecu
        # Without folders: nothing of a survey is kept for other commands, and no passport is read
        # to find what they have kept.
        self.parameters: Parameters = Ecu(ecu.tester, ecu.catalog).parameters
        self.capture: SurveyCapture | None = None
        self.tester: Tester = ecu.tester
        self.catalog: Catalog = ecu.catalog
        self.sizes: dict[int, int] = {}
        self.longest: int = 1

    def now(self) -> float:
        """Return the link's clock."""
        return self.tester.link.now()

    def ask(self, body: bytes, *, times: int = 2, damages: int = _DAMAGED) -> Reply | None:
        """Return the response to `body`; None after silence to each of `times` requests.

        Raises a `LineError` if the line damages `damages` responses, or a `NoConnection`.
        """
        return self.send(AnyRequest(body), times=times, damages=damages)

    def send(
        self, command: Command[bytes], *, times: int = 2, damages: int = _DAMAGED
    ) -> Reply | None:
        """As `ask`, for a command."""
        damaged = 0
        while times:
            try:
                return self.tester.exchange(command, retries=0, trial=True)[1]
            except (errors.NotSupported, errors.NoResponse):
                times -= 1
            except (errors.SyncLost, errors.LineNotQuiet):
                raise
            except errors.LineError:
                damaged += 1
                if damaged == damages:
                    raise
        return None

    def data(self, codes: Sequence[int]) -> dict[int, bytes]:
        """Return the data of known `codes`, as far as they come."""
        found: dict[int, bytes] = {}
        for start in range(0, len(codes), self.longest):
            listed = codes[start : start + self.longest]
            reply = self.ask(bytes([0x61, *listed]))
            if reply is not None:
                found |= self.split(listed, reply.body)
        return found

    def split(self, codes: Iterable[int], body: bytes) -> dict[int, bytes]:
        """Return the data in a body by code; empty if its length is another."""
        found, start = {}, 0
        for code in codes:
            found[code] = body[start : start + self.sizes[code]]
            start += self.sizes[code]
        return found if start == len(body) else {}

    def rpm(self) -> float | None:
        """Return the engine's speed; None: the unit does not give it."""
        codes = self.speed_codes
        return speed_of(self.data(codes)) if codes else None

    def find_speed(self) -> None:
        """Find out whether the unit has FREQ or FREQX, before any other code is asked for.

        Listed twice, for `01` alone may be a refusal (D10); alone, for a unit that takes one code.
        """
        for code in _RPM:
            if code not in self.sizes:
                pair = self.ask(bytes([0x61, code, code]))
                if pair is not None and len(pair.body) == 2:
                    self.sizes[code] = 1
                    continue
                alone = self.ask(bytes([0x61, code]))
                if alone is not None and len(alone.body) == 1 and alone.body != b"\x01":
                    self.sizes[code] = 1

    @property
    def speed_codes(self) -> list[int]:
        """FREQ and FREQX, as far as the unit has them with one byte."""
        return [code for code in _RPM if self.sizes.get(code) == 1]

    def one_byte_codes(self) -> list[int]:
        """Return the known codes of one byte, those that the engine does not move first."""
        moving = (SPEED, IDLE_SPEED, VOLTAGE)
        codes = [code for code, size in sorted(self.sizes.items()) if size == 1]
        return sorted(codes, key=lambda code: code in moving)

    @contextmanager
    def hasty(self, slowest: float) -> Iterator[None]:
        """Wait less for a response: the slowest so far began after `slowest` seconds."""
        line, retries = self.tester.line, self.tester.retries
        usual, granularity = line.timing, self.tester.link.granularity
        seconds = min(usual.response_timeout, max(_HASTE, 4 * slowest) + 2 * granularity)
        line.timing, self.tester.retries = replace(usual, response_timeout=seconds), 0
        try:
            yield
        finally:
            line.timing, self.tester.retries = usual, retries

    def is_back(self) -> bool:
        """Return whether the unit, which seemed gone, still answers: the line had lost something.

        Raises a `NoConnection` if the adapter is gone.
        """
        for _ in range(_LOOKS):
            self.pause(_PATIENCE)
            try:
                self.tester.exchange(Availability())
            except (errors.EchoOnly, errors.NoEcho, errors.LineError):
                continue
            return True
        return False

    def pause(self, seconds: float) -> None:
        """Let time pass."""
        self.tester.wait(self.now() + seconds)

    def recording_paused(self, *, paused: bool) -> AbstractContextManager[None]:
        """Record nothing while the block runs, if `paused`."""
        return self.capture.pausing() if paused and self.capture else nullcontext()

    @contextmanager
    def without_pause(self) -> Iterator[None]:
        """Send requests as soon as they are given, and find no pause by trying."""
        tester = self.tester
        pauses, pause = tester.pauses, tester.line.pause
        self._keep_pause(0.0)
        try:
            yield
        finally:
            tester.pauses, tester.line.pause = pauses, pause

    def _keep_pause(self, seconds: float) -> None:
        tester = self.tester
        tester.pauses = Pauses(tester.line, tester.sync, seconds, tester.ends.check)

    def use_what_is_known(self, measured: dict[str, Any]) -> None:
        """Ask as the unit was found to answer: the pause that it needs, the longest list, the form
        of the checksum (D3).
        """
        pause = measured.get("least_pause", {}).get("pause")
        if pause is not None:
            self._keep_pause(pause and pause * _SPARE + _ROUNDED)
        limit = measured.get("lists", {}).get("61", {}).get("limit")
        if limit is not None:
            self.longest = min(_ROOM, limit)
        forms = {
            form
            for each in measured.get("checksum_accepted", {}).values()
            for form, is_understood in each.items()
            if is_understood
        }
        if forms == {"raw"}:
            self.tester.line.raw_checksum = True


def speed_of(data: dict[int, bytes]) -> float | None:
    """Return rpm by FREQX where that is within its range, else by FREQ (E1); None without both."""
    found = {code: data[code][0] * step for code, step in _RPM.items() if code in data}
    fine = found.get(IDLE_SPEED)
    if fine is not None and fine < 0xFF * _RPM[IDLE_SPEED]:
        return float(fine)
    return float(found[SPEED]) if SPEED in found else None
