"""What this computer's page switches of the program: its side in the network, and its end.

Off, the program listens on 127.0.0.1 only. On, it listens in addition on each of this computer's
addresses in the network, at the same port, with TLS: `Access` gets a new token, the names and the
fingerprint. The addresses are followed while it is on: one that is new (a hotspot, another Wi-Fi)
is listened on, gets into mikas' own certificate and the links; one that has gone is no valid `Host`
any more, and its socket is closed; the token stays. Off again, the token is void before anything
else happens; then the listening sockets and all connections of the network are closed. A program
that was started with `--lan` listens on all addresses from its start; its network side is switched
alike, but the socket stays. Nothing is kept: a start without `--lan` begins closed.

A program that an icon has started has no terminal for Ctrl-C: the page's button ends it. It also
ends by itself, ten minutes after its last page was closed, so that nothing forgotten holds the
adapter; not while it records or reads a dump.

Only a client on this computer may switch (`api.network`).
"""

from __future__ import annotations

import asyncio
import logging
import socket
import ssl
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Final

from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.errors import Busy
from mikas.dashboard.network.addresses import is_number
from mikas.dashboard.network.listening import bound
from mikas.dashboard.security.access import Access
from mikas.dashboard.security.certificate import Certificate, own_certificate
from mikas.errors import UsageError, reason_of
from mikas.i18n import Text

if TYPE_CHECKING:
    from mikas.dashboard.entrance import Entrance

_NO_NETWORK = Text(
    "this computer has no address in a network. Connect it to the Wi-Fi of the phone, or to the "
    "phone's hotspot, then switch on again",
    "у этого компьютера нет адреса в сети. Подключите его к той же сети Wi-Fi, что и телефон, или "
    "к точке доступа телефона и включите снова",
)
_NOT_ENCRYPTED = Text(
    "the program was started with --no-tls. Restart it without that option",
    "программа запущена с --no-tls. Перезапустите её без этого ключа",
)
AWAY: Final = 600.0
"""Seconds without a page. A page that the browser has only put to sleep keeps its connection."""

_TERMINAL: Final = Text(
    "the program was started in a terminal. End it there, with Ctrl-C",
    "программа запущена из терминала. Завершите её там клавишами Ctrl-C",
)

_log = logging.getLogger("mikas.dashboard")


class Sharing:
    """The switch of the network. All of it runs in the event loop.

    `certificate`: the one in use since the start (`--lan`); None: mikas makes its own when it is
    needed. `here`: this computer's addresses and names at that start; none: they are not followed.
    """

    def __init__(
        self,
        dashboard: Dashboard,
        access: Access,
        certificate: Certificate | None = None,
        here: Sequence[str] = (),
    ) -> None:
        self._here = tuple(here)
        self._following: asyncio.Task[None] | None = None
        self._dashboard, self._access, self._certificate = dashboard, access, certificate
        self._plain = access.lan and certificate is None and access.fingerprint is None
        self._used = certificate
        self._lock = asyncio.Lock()
        self._create: Callable[[socket.socket, ssl.SSLContext], Entrance] | None = None
        self._first: Sequence[Entrance] = ()
        self._opened: list[Entrance] = []

    def attach(
        self,
        create: Callable[[socket.socket, ssl.SSLContext], Entrance],
        first: Sequence[Entrance] = (),
    ) -> None:
        """Set how an entrance is opened, and those of the start; called by the server."""
        self._create, self._first = create, first

    async def open(self, *, control: bool) -> None:
        """Open to the network, to view or to control; an open one gets a new token.

        Raises `Busy` with the reason, and `UsageError` if the certificate can't be made.
        """
        async with self._lock:
            if self._plain or self._create is None:
                raise Busy(problem=_NOT_ENCRYPTED)
            await self._shut()
            here = await asyncio.to_thread(self._dashboard.settings.addresses)
            if not any(map(is_number, here)):
                raise Busy(problem=_NO_NETWORK)
            certificate = await self._certified(here)
            self._here = self._listen(here, certificate)
            for entrance in self._first:
                entrance.admit_network(certificate.context)
            hosts = certificate.hosts(self._here)
            self._access.share(hosts, certificate.fingerprint, control=control)
            self._dashboard.lan = True

    async def _certified(self, here: Sequence[str]) -> Certificate:
        """Return the user's certificate, or mikas' own one for `here`. Raises `UsageError`.

        A new one for a new address has another fingerprint: those who come by an
        earlier address are asked once more by their browsers; open pages stay connected.
        """
        if self._certificate is not None and not self._certificate.is_own:
            return self._certificate
        file, now = self._dashboard.settings.certificate, datetime.now(UTC)
        made = await asyncio.to_thread(own_certificate, file, here, now)
        if self._used is None or made.fingerprint != self._used.fingerprint:
            self._used = made
        return self._used

    def _listen(self, here: Sequence[str], certificate: Certificate) -> tuple[str, ...]:
        """Listen on each new address; return `here` without those that can't be opened.

        Raises `Busy` if none can.
        """
        assert self._create is not None
        if self._first:
            return tuple(here)
        opened = {entrance.own.getsockname()[0] for entrance in self._opened}
        sockets = self._bound([it for it in here if is_number(it) and it not in opened])
        self._opened += [self._create(own, certificate.context) for own in sockets]
        opened |= {own.getsockname()[0] for own in sockets}
        return tuple(name for name in here if name in opened or not is_number(name))

    def check(self) -> None:
        """Follow this computer's addresses; the server calls this once a second."""
        is_idle = self._following is None or self._following.done()
        if self._dashboard.lan and self._here and is_idle:
            self._following = asyncio.get_running_loop().create_task(self._follow())

    async def _follow(self) -> None:
        async with self._lock:
            here = await asyncio.to_thread(self._dashboard.settings.addresses)
            if not self._dashboard.lan or here == self._here:
                return
            if self._plain:
                self._here = here
                self._access.follow(here, None)
                return
            try:
                certificate = await self._certified(here)
                self._here = self._listen(here, certificate)
            except (Busy, UsageError) as error:  # tried again; the open ones stay
                _log.debug("an address is not followed yet: %s", error)
                return
            await self._close_but(here)
            for entrance in (*self._first, *self._opened):
                if entrance.context is not certificate.context:
                    entrance.admit_network(certificate.context)
            self._access.follow(certificate.hosts(self._here), certificate.fingerprint)

    async def close_for_good(self) -> None:
        """Close everything at the end of the program."""
        if self._following is not None:
            self._following.cancel()
        async with self._lock:
            await self._shut()

    async def close(self) -> None:
        """Close to the network; the token and all connections of the network end at once."""
        async with self._lock:
            if self._plain:
                raise Busy(problem=_NOT_ENCRYPTED)
            await self._shut()

    async def _close_but(self, here: Sequence[str]) -> None:
        """Close the sockets of addresses that have gone."""
        gone = [each for each in self._opened if each.own.getsockname()[0] not in here]
        self._opened = [each for each in self._opened if each not in gone]
        for entrance in gone:
            await entrance.close()
            entrance.own.close()

    async def _shut(self) -> None:
        self._access.unshare()
        self._dashboard.lan = False
        self._dashboard.control.expel()
        for entrance in (*self._first, *self._opened):
            entrance.admit_network(None)
        await self._close_but(())

    def _bound(self, numbers: Sequence[str]) -> list[socket.socket]:
        """Return a socket for each address at which the port is free. Raises `Busy` if none is."""
        found, failure = [], None
        for number in numbers:
            try:
                found.append(bound(number, self._access.port))
            except OSError as error:
                failure = number, error
        if found or failure is None:
            return found
        why, at = reason_of(failure[1]), f"{failure[0]}:{self._access.port}"
        busy = Busy(
            problem=Text(
                f"the address {at} can't be opened: {why.en}. Another program may use this port "
                "there: restart with another --host-port",
                f"адрес {at} открыть не удаётся: {why.ru}. Возможно, этот порт там занят другой "
                "программой: перезапустите с другим --host-port",
            )
        )
        raise busy.caused_by(failure[1]) from failure[1]


class Ending:
    """Ends `dashboard`'s program. All of it runs in the event loop."""

    def __init__(self, dashboard: Dashboard) -> None:
        self._dashboard = dashboard
        self._end: Callable[[], None] | None = None
        self._used = dashboard.clock()

    def attach(self, end: Callable[[], None]) -> None:
        """Set how the program ends; called by the server."""
        self._end = end
        self._used = self._dashboard.clock()

    def end_program(self) -> None:
        """End the program in good order: the recording and the port are closed. Raises `Busy`."""
        if not self._dashboard.settings.desktop or self._end is None:
            raise Busy(problem=_TERMINAL)
        self._end()

    def check(self) -> None:
        """End the program if it is not used any more; the server calls this once a second."""
        dashboard = self._dashboard
        now = dashboard.clock()
        if (
            dashboard.control.viewers
            or dashboard.recorder.file_name
            or any(job.phase == "running" for job in dashboard.dump_jobs.jobs.values())
        ):
            self._used = now
        elif dashboard.settings.desktop and now - self._used >= AWAY:
            self.end_program()
