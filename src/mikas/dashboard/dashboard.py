"""The hub: one unit, one sampling thread, one recorder, and everybody who looks or asks.

    sampling thread ── events ──► Story ──► drained 20 times a second by the broadcaster
                    ◄── jobs ───  ask      awaited by the event loop, never waited for
                    ── bytes ───► Recorder

Only the controller's requests come here to change anything; who that is, is the routes' business.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar

from mikas.dashboard.errors import NotConnected
from mikas.dashboard.security.approval import Approval
from mikas.dashboard.security.confirmations import Nonces
from mikas.dashboard.security.control import Seat
from mikas.dashboard.security.write_lock import WritingLock
from mikas.dashboard.session.connection import turn
from mikas.dashboard.session.dump_jobs import Dumping
from mikas.dashboard.session.fault_history import FaultHistory, StoredFaults
from mikas.dashboard.session.history import History
from mikas.dashboard.session.manager import Switch
from mikas.dashboard.session.monitor import DIAGNOSIS, RECONNECTED, ConnectionMonitor
from mikas.dashboard.session.plan import Planning
from mikas.dashboard.session.recorder import RecordingDesk
from mikas.dashboard.session.thread import Session
from mikas.dashboard.settings import Settings
from mikas.dashboard.wishes import Way, Wish
from mikas.errors import MikasError
from mikas.i18n import Text
from mikas.sampling.events import LineState, StateChanged, UnitFound

if TYPE_CHECKING:
    from mikas.client import Ecu, Info, Support
    from mikas.client.polling import FixedMethod
    from mikas.dashboard.session.diagnosis import Examination
    from mikas.sampling.events import Event

T = TypeVar("T")

_ANSWER = 30.0  # s that a request waits for its turn
_ALIVE = (LineState.ECU_ALIVE, LineState.SAMPLING)


class Hub:
    """`begin`: a port that is connected to at once, when the application starts."""

    def __init__(
        self,
        settings: Settings,
        *,
        begin: str | None = None,
        lan: bool = False,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.settings = settings
        self.catalog = settings.connection.catalog
        self.lan = lan
        self.clock = clock
        """Seconds for seats, nonces and locks, which are people's time and not the link's."""
        self.lock = WritingLock(clock)
        self.seat = Seat(clock, changed=self.lock.close)
        self.history = History()
        self.monitor = ConnectionMonitor(self.history)
        self.fault_history = FaultHistory()
        self.approval = Approval()
        self._unit: UnitFound | None = None
        self.recording = RecordingDesk(self)
        self.dumping = Dumping(self)
        self.nonces = Nonces(clock)
        self.info: Info | None = None
        self.supported: list[Support] | None = None
        self.examination: Examination | None = None
        """The doctor's, while it has the port."""
        self.planning = Planning(self)
        self.wish = Wish(dict.fromkeys(self.planning.channels, 1))
        self.switch = Switch(
            settings,
            Way(begin, settings.connection.echo) if begin else None,
            begin=self._begun,
            over=self._over,
        )

    @asynccontextmanager
    async def running(self) -> AsyncIterator[None]:
        """As long as the application runs; at its end the recording is closed, the port let go."""
        await asyncio.to_thread(self.dumping.find)
        self.switch.start()
        try:
            yield
        finally:
            await self.dumping.close()
            if self.examination is not None:
                await self.examination.end()
            await self.switch.close()
            self.recording.close()

    # The connection

    @property
    def session(self) -> Session | None:
        """The connection of now."""
        return self.switch.session

    @property
    def way(self) -> Way | None:
        """How the unit is reached."""
        return self.switch.way

    async def connect(
        self,
        url: str | None,
        *,
        echo: str = "auto",
        method: FixedMethod | None = None,
        rate: float | None = None,
    ) -> None:
        """As `Switch.connect`, asking by `method`, at most so often."""

        def wanted(url: str) -> None:
            self.wish = replace(self.wish, method=method, rate=rate)
            if self.way is None or url != self.way.url:
                self.recording.part()

        await self.switch.connect(url, echo=echo, wanted=wanted)

    async def disconnect(self) -> None:
        """Ends the recording and lets go of the port."""
        await self.switch.disconnect()
        self.recording.stop()

    def _begun(self, way: Way) -> Session:
        session = Session(
            way.url,
            self.settings,
            self.wish.names,
            echo=way.echo,
            method=self.wish.method,
            rate=self.wish.rate,
            sink=self.recording.recorder,
            confirm=self.approval.confirm,
            tell=self._told,
            ended=self._ended,
        )
        self.monitor.begin(self.wish.every, session.now())
        return session

    def _over(self, session: Session, why: Text) -> None:
        if why in (RECONNECTED, DIAGNOSIS):
            self.recording.pause(session.now(), why)
        self.monitor.end(session.now(), None, why)
        self._forget_unit()

    def _forget_unit(self) -> None:
        """What was read of one unit, or confirmed for it, is nothing to another."""
        self.fault_history.disconnect()
        self.nonces.clear()
        self.info = self.supported = None
        self.lock.close()

    def _told(self, session: Session, event: Event) -> None:
        """In the sampling thread."""
        if session is not self.session:
            return
        if isinstance(event, UnitFound):
            event = self._met(event)
        self.recording.take(event, session)
        self._measure(session)
        self.monitor.take(event)
        if isinstance(event, UnitFound):
            if event.another:
                self._forget_unit()
                self.fault_history.forget()
            session.call(self.read_faults)
        if isinstance(event, StateChanged):
            self.switch.heard()

    def _ended(self, session: Session, error: MikasError | None) -> None:
        """In the sampling thread: it ended by itself."""
        if session is self.session:
            self.monitor.end(session.now(), error)
            self.switch.heard()

    def _met(self, event: UnitFound) -> UnitFound:
        """`event`, also comparing with the unit of the connection before."""
        before, self._unit = self._unit, event
        return event if before is None or event.may_be(before) else replace(event, another=True)

    # What is asked

    async def ask(self, job: Callable[[Ecu], T], *, seconds: float = _ANSWER) -> T:
        """What `job(ecu)` returns, done between two cycles. Raises what it raises, `NotConnected`,
        `Busy` if its turn did not come within `seconds`.
        """
        session = self.session
        if session is None or self.monitor.line not in _ALIVE:
            raise self.nobody()

        def in_turn(ecu: Ecu) -> T:
            self.monitor.busy()
            return job(ecu)

        return await turn(session, in_turn, seconds)

    def read_faults(self, ecu: Ecu) -> StoredFaults:
        """A job: reads the stored faults into the book."""
        return self.fault_history.add(ecu.faults(), ecu.tester.link.now())

    def look(self) -> None:
        """Sees what nobody tells; a few times a second, while anybody looks."""
        self.recording.look()
        if (session := self.session) is not None:
            self._measure(session)

    def _measure(self, session: Session) -> None:
        now, ecu, meters = session.now(), session.ecu, self.monitor.meters
        with self.monitor.lock:
            meters.wire(now, self.recording.recorder.wire_bytes)
            if ecu is not None:
                self.monitor.count_failures(tuple(ecu.tester.statistics.failures.copy()), now)

    def now(self) -> float:
        """The link's clock; without a link, the computer's."""
        session = self.session
        return time.time() if session is None else session.now()

    @property
    def ecu(self) -> Ecu | None:
        """The unit of now, to be looked at only."""
        return session.ecu if (session := self.session) else None

    @property
    def is_demo(self) -> bool:
        """Whether the car is a virtual one."""
        return (way := self.way) is not None and way.url.startswith("sim:")

    def nobody(self) -> NotConnected:
        """There is nobody to ask, and why."""
        error = NotConnected()
        reason = self.monitor.reason
        return NotConnected(advice=reason) if reason else error
