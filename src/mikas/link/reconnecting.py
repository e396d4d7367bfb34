"""A port that is opened again after its adapter was unplugged, perhaps under another name.

A lost `Link` stays lost; this port opens a new one, of the same adapter (`identity`): a name may be
a stranger's by then. The name is looked up before opening and again after it, so that an adapter
which took the name in between is let go before a byte is sent.

A connection over a network that died without a word is noticed here (`network.silence`), and
replaced by the next one.

The port has a clock of its own, which runs without a link and is never set. Each new link continues
it, also if the computer's date was set in between. `dated` is what the date is compared with, and
`slept` adds a sleep in which the clock stood still.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import InitVar, dataclass, field
from typing import Final

from mikas.errors import AnotherAdapter, PortKind, PortNotFound
from mikas.i18n import Text
from mikas.link.base import CaptureTee, Chunk, Link, LinkWrapper, Sink, WireCount
from mikas.link.clocks import WallClock
from mikas.link.identity import KnownAdapter, identity_of, is_same
from mikas.link.interface import check_link
from mikas.link.network.silence import SilenceGuard
from mikas.link.ports import Port, find_ports, listed, named
from mikas.link.suspension import LATE_IN_PROGRAM, SuspensionGuard
from mikas.link.urls import open_link, parse, with_name

_LAG: Final = 1.0  # s; less is the time between the reading of two clocks
_MOMENT: Final = 0.1  # s between the reading of two clocks; else the thread was stopped


@dataclass(slots=True, kw_only=True, eq=False)
class ReconnectingPort:
    """Opens the same port repeatedly. `sink` records every link.

    `wall`: the clock of all links, and the computer's date; `clock`: one without a date, for tests.

    `wait`: sleeps for some seconds; Ctrl-C interrupts it. `wire`: the bytes on the line, where a
    sink records them. `adapter`: the one that is opened; None: the first one at `url`, or known by
    its name only. `timeout`: seconds to the first byte of a response (D14), for a slow network.
    """

    url: str = field(kw_only=False)
    find: Callable[[], list[Port]] = find_ports
    open_port: Callable[[str], Link] = open_link
    clock: InitVar[Callable[[], float] | None] = None
    wall: WallClock | None = None
    wait: Callable[[float], object] = time.sleep
    sink: Sink | None = None
    wire: WireCount = field(default_factory=WireCount)
    adapter: KnownAdapter | None = None
    timeout: float = 0.5
    _link: Link | None = None
    _clock: Callable[[], float] = field(init=False)
    _ahead: float = 0.0  # the latest link's clock minus `_clock`

    def __post_init__(self, clock: Callable[[], float] | None) -> None:
        if clock is None:
            self.wall = self.wall or WallClock()
            clock = self.wall.now
        self._clock = clock

    def open(self) -> Link:
        """Open the adapter under its present name, which `url` then is.

        Raises `NoConnection`: `AnotherAdapter` if its name or its kind is another's.
        """
        link = self._open_adapter() if parse(self.url).is_adapter else self.open_port(self.url)
        check_link(link, "what open_port returns")
        if link.kind is PortKind.NETWORK:
            link = SilenceGuard(link, timeout=self.timeout)
        if not link.is_simulated:
            if link.is_virtual:  # `open_link` returns it as it is
                link = SuspensionGuard(link, LATE_IN_PROGRAM)
            link = _SteadyLink(link, self.now() - link.now())
        elif self._link is not None and (lag := self.now() - link.now()) > 0:
            link = _SteadyLink(link, lag)
        self._link = link
        self._ahead = link.now() - self._clock()
        return link if self.sink is None else CaptureTee(link, self.sink, self.wire)

    def _open_adapter(self) -> Link:
        name = parse(self.url).name
        present = self.find()
        port = self.adapter.locate(present, name) if self.adapter else named(name, present)
        if port is not None and named(name, [port]) is None:
            name = port.url
            self.url = with_name(self.url, name)
        link = self.open_port(self.url)
        present = self.find()
        after = named(name, present)
        if not is_same(port, after):
            link.close()
            raise _changed(name, after, present)
        if port is not None and identity_of(port) is not None:
            self.adapter = self.adapter or KnownAdapter(port, present)
            self.adapter.opened(port)
        return link

    @property
    def link(self) -> Link | None:
        """The latest link, open or lost; None before the first."""
        return self._link

    def now(self) -> float:
        """Return the seconds of a clock that runs without a link and never runs back."""
        now = self._clock() + self._ahead
        return now if self._link is None else max(now, self._link.now())

    def dated(self) -> tuple[float, float] | None:
        """Return `now` and the computer's date of the same moment.

        None: time is simulated, or the thread was stopped in between.
        """
        if self.wall is None or (self._link is not None and self._link.is_simulated):
            return None
        now, date = self.now(), self.wall.date()
        return (now, date) if self.now() - now < _MOMENT else None

    @property
    def stood_still(self) -> float:
        """The seconds of a sleep in which the latest link's clock stood still, and this one not.

        A virtual car's time does not pass then. 0: none.
        """
        if self.wall is None or not isinstance(self._link, _SteadyLink):
            return 0.0
        lag = self._clock() + self._ahead - self._link.now()
        return lag if lag >= _LAG and not self._link.is_simulated else 0.0

    def slept(self, seconds: float) -> None:
        """Add a sleep in which the link's clock stood still; between two exchanges."""
        behind = seconds
        if isinstance(self._link, _SteadyLink):
            self._link.ahead += seconds
            behind = self._link.now() - self._clock() - self._ahead
        if self.wall is not None:
            self.wall.skip(max(0.0, behind))


def _changed(address: str, after: Port | None, present: list[Port]) -> PortNotFound:
    """Return the error of a port that became another adapter's while it was opened."""
    if after is None:
        return PortNotFound(url=address, found=listed(present))
    problem = Text(
        f"another adapter took its port {address} just now ({after.description})",
        f"его порт {address} только что занял другой ({after.description})",
    )
    return AnotherAdapter(url=address, problem=problem)


class _SteadyLink(LinkWrapper):
    """`link`, with a clock that is `ahead` of its own."""

    def __init__(self, link: Link, ahead: float) -> None:
        super().__init__(link)
        self.opened = link.opened + ahead
        self.ahead = ahead

    def read(self, deadline: float) -> Chunk:
        chunk = self.link.read(deadline - self.ahead)
        return Chunk(chunk.data, chunk.time + self.ahead)

    def gather(self, until: float) -> None:
        self.link.gather(until - self.ahead)

    def take_back(self) -> float | None:
        written = self.link.take_back()
        return None if written is None else written + self.ahead

    def now(self) -> float:
        return self.link.now() + self.ahead
