"""A port that is opened again after its adapter was unplugged, perhaps under another name.

A lost `Link` stays lost; this port opens a new one, of the same adapter (`identity`): a name may be
a stranger's by then. The name is looked up before opening and again after it, so that an adapter
which took the name in between is let go before a byte is sent.

A connection over a network that died without a word is noticed here (`network.silence`), and
replaced by the next one.

The port has a clock of its own for the time without a link. A new link whose clock would run back
(the computer's date was set back) continues the port's clock.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import InitVar, dataclass, field

from mikas.errors import AnotherAdapter, PortKind, PortNotFound
from mikas.i18n import Text
from mikas.link.base import CaptureTee, Chunk, Link, LinkWrapper, Sink, WallClock, WireCount
from mikas.link.identity import KnownAdapter, identity_of, is_same
from mikas.link.network.silence import SILENT, SILENT_AGAIN, SilenceGuard
from mikas.link.ports import Port, find_ports, listed, named
from mikas.link.suspension import LATE_IN_PROGRAM, SuspensionGuard
from mikas.link.urls import open_link, parse, with_name


@dataclass(slots=True, kw_only=True, eq=False)
class ReconnectingPort:
    """Opens the same port repeatedly. `sink` records every link; `clock` is for tests.

    `wait`: sleeps for some seconds; Ctrl-C interrupts it. `wire`: the bytes on the line, where a
    sink records them. `adapter`: the one that is opened; None: the first one at `url`, or known by
    its name only.
    """

    url: str = field(kw_only=False)
    find: Callable[[], list[Port]] = find_ports
    open_port: Callable[[str], Link] = open_link
    clock: InitVar[Callable[[], float] | None] = None
    wait: Callable[[float], object] = time.sleep
    sink: Sink | None = None
    wire: WireCount = field(default_factory=WireCount)
    adapter: KnownAdapter | None = None
    _link: Link | None = None
    _guard: SilenceGuard | None = None  # of the latest link, over a network
    _clock: Callable[[], float] = field(init=False)
    _ahead: float = 0.0  # the latest link's clock minus `_clock`

    def __post_init__(self, clock: Callable[[], float] | None) -> None:
        self._clock = clock or WallClock().now

    def open(self) -> Link:
        """Open the adapter under its present name, which `url` then is.

        Raises `NoConnection`: `AnotherAdapter` if its name or its kind is another's.
        """
        link = self._open_adapter() if parse(self.url).is_adapter else self.open_port(self.url)
        if link.kind is PortKind.NETWORK:
            again = self._guard is not None and not self._guard.heard
            link = self._guard = SilenceGuard(link, SILENT_AGAIN if again else SILENT)
        if self._link is not None and (lag := self.now() - link.now()) > 0:
            link = _AheadLink(link, lag)
        self._link = link
        self._ahead = link.now() - self._clock()
        if link.is_virtual and not link.is_simulated:  # `open_link` returns it as it is
            link = SuspensionGuard(link, LATE_IN_PROGRAM)
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

    def now(self) -> float:
        """Return the seconds of a clock that runs without a link and never runs back."""
        now = self._clock() + self._ahead
        return now if self._link is None else max(now, self._link.now())


def _changed(address: str, after: Port | None, present: list[Port]) -> PortNotFound:
    """Return the error of a port that became another adapter's while it was opened."""
    if after is None:
        return PortNotFound(url=address, found=listed(present))
    problem = Text(
        f"another adapter took its port {address} just now ({after.description})",
        f"его порт {address} только что занял другой ({after.description})",
    )
    return AnotherAdapter(url=address, problem=problem)


class _AheadLink(LinkWrapper):
    """`link`, with a clock that is `ahead` of its own."""

    def __init__(self, link: Link, ahead: float) -> None:
        super().__init__(link)
        self.opened = link.opened + ahead
        self._ahead = ahead

    def read(self, deadline: float) -> Chunk:
        chunk = self.link.read(deadline - self._ahead)
        return Chunk(chunk.data, chunk.time + self._ahead)

    def gather(self, until: float) -> None:
        self.link.gather(until - self._ahead)

    def now(self) -> float:
        return self.link.now() + self._ahead
