"""Rights of a request by its host and token, and the ports that it may name.

    on this computer     Host and Origin must be this server's    control
    open to the network  a token in addition                      view; with lan_control: control

The network is served over TLS, this computer's own address is not (`dashboard/entrance.py`).

Host is checked against DNS rebinding (a foreign name that leads to 127.0.0.1), Origin and
Sec-Fetch-Site against pages of other sites, for HTTP and WebSocket alike. The token comes as
`Authorization: Bearer`, as a cookie, or once in the link; then the server sets it as a cookie, so
that it does not stay in the address bar.

The sender's address is the one of its connection; no header names another. A request that a proxy
on this computer passes on has this computer's address but another author: it is not local.

A port's URL can name a recording to replay, a scenario's file, any address that this computer can
reach. From the network (`--lan-control`) only a serial port that was found, the port in use, or a
virtual car that comes with mikas may be named.
"""

from __future__ import annotations

import hmac
import ipaddress
import secrets
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

from starlette.requests import HTTPConnection
from starlette.types import Scope

from mikas.dashboard.errors import Forbidden, NotFromNetwork, TokenRequired
from mikas.dashboard.network.addresses import is_ipv6, is_number
from mikas.dashboard.network.listening import is_loopback
from mikas.i18n import Text
from mikas.link import Port
from mikas.link.urls import parse

Rights = Literal["control", "view"]
_CAR_OPTIONS = {"scenario", "car", "seed", "model", "faults"}
# 8 bytes in pairs of digits: too many to make another certificate with the same ones
_SHORT = 8 * 3 - 1
_LOCAL = ("127.0.0.1", "localhost", "::1")
_FORWARDING = ("forwarded", "via", "x-forwarded-for", "x-forwarded-host", "x-real-ip")


@dataclass(frozen=True, slots=True)
class LanLink:
    """A link for other computers; `reached`: one of them has come by it with the token."""

    address: str
    url: str
    reached: bool


@dataclass(slots=True)
class Access:
    """The rules in force. `hosts`: this computer's addresses and names as they are now, with `lan`.

    `share`, `follow` and `unshare` change the network at run time (`mikas.dashboard.program`).

    `fingerprint`: of the certificate, in pairs of digits; None: the network gets plain HTTP.
    """

    port: int
    lan: bool = False
    lan_control: bool = False
    hosts: tuple[str, ...] = ()
    token: str = field(default_factory=lambda: secrets.token_urlsafe(18), repr=False)
    fingerprint: str | None = None
    instance: str = field(default_factory=lambda: secrets.token_hex(8))
    """A mark of this run, which gives no rights (`mikas.dashboard.running`)."""
    followed: Callable[[], object] = field(default=lambda: None, repr=False)
    """Called after each change of the addresses."""
    _reached: set[str] = field(default_factory=set, repr=False)
    """The addresses by which others have come with the token, as in `Host`."""

    def share(self, hosts: tuple[str, ...], fingerprint: str, *, control: bool) -> None:
        """Let the network in, by a new token."""
        self.hosts, self.fingerprint, self.lan_control = hosts, fingerprint, control
        self.token, self.lan = _new_token(), True
        self._reached.clear()

    def follow(self, hosts: tuple[str, ...], fingerprint: str | None) -> None:
        """Take the addresses as they are now; the token stays, so do those who have it."""
        self.hosts, self.fingerprint = hosts, fingerprint
        self.followed()

    def unshare(self) -> None:
        """Refuse the network; the token is void."""
        self.lan = self.lan_control = False
        self.token, self.hosts, self.fingerprint = _new_token(), (), None

    @property
    def url(self) -> str:
        """The address for a browser on this computer."""
        return f"http://127.0.0.1:{self.port}/"

    @property
    def lan_url(self) -> str | None:
        """The link that most likely works."""
        return next((link.url for link in self.lan_links), None)

    @property
    def lan_links(self) -> tuple[LanLink, ...]:
        """The links for other computers, the likeliest first; names only where no address is.

        Each with the token, and the begin of the fingerprint. Browsers do not send the latter. A
        person compares it with the certificate that the browser shows before it opens the page.
        """
        if not self.lan:
            return ()
        numbers = [host for host in self.hosts if is_number(host)]
        hosts = self.hosts if not numbers else self.hosts[: self.hosts.index(numbers[-1]) + 1]
        return tuple(self._link(host) for host in hosts)

    def _link(self, host: str) -> LanLink:
        address = self._address(host)
        url = f"{address}/?token={self.token}"
        if self.fingerprint is None:
            url = f"http://{url}"
        else:
            url = f"https://{url}#sha256={self.fingerprint[:_SHORT]}"
        return LanLink(host, url, address in self._reached)

    @property
    def cookie(self) -> str:
        """The cookie's name; browsers share cookies between ports."""
        return f"mikas_{self.port}"

    def judge(self, scope: Scope) -> Rights:
        """Return the rights of the sender. Raises `Forbidden`, `TokenRequired`."""
        request = HTTPConnection(scope)
        self._check_host(request)
        self._check_page(request)
        if self.is_local(scope):
            return "control"
        if not self.lan:
            raise Forbidden(problem=Text("a request through a proxy", "запрос через прокси"))
        if not self._has_token(request):
            raise TokenRequired
        if request.client is not None and request.client.host not in self.hosts:
            self._reached.add(_host(request))
        return "control" if self.lan_control else "view"

    def is_local(self, scope: Scope) -> bool:
        """Whether the request comes from this computer, which needs no token."""
        request = HTTPConnection(scope)
        if any(name in request.headers for name in _FORWARDING):
            return False
        local = _host(request) in self._addresses(local=True)
        return local and request.client is not None and is_loopback(request.client.host)

    def offers_token(self, scope: Scope) -> bool:
        """Whether the link with the right token is being opened; a cookie is to be set."""
        return (
            self.lan
            and scope["type"] == "http"
            and scope["path"] == "/"
            and self._is_token(HTTPConnection(scope).query_params.get("token", ""))
        )

    def _check_host(self, request: HTTPConnection) -> None:
        host = _host(request)
        if host not in self._addresses():
            raise Forbidden(
                problem=Text(f"unknown host “{host}”", f"неизвестное имя узла «{host}»")
            )

    def _addresses(self, *, local: bool = False) -> set[str]:
        hosts = (*_LOCAL, *(self.hosts if self.lan and not local else ()))
        found = {self._address(host) for host in hosts}
        if self.port == 80:
            found |= {address.removesuffix(":80") for address in found}
        return found

    def _address(self, host: str) -> str:
        """Return a host as a URL has it, with the port."""
        return f"[{host}]:{self.port}" if is_ipv6(host) else f"{host.lower()}:{self.port}"

    def _check_page(self, request: HTTPConnection) -> None:
        headers = request.headers
        origin = headers.get("origin")
        if origin is not None:
            scheme, _, address = origin.lower().partition("://")
            own = "https" if is_encrypted(request.scope) else "http"
            if scheme != own or address not in self._addresses():
                raise Forbidden(
                    problem=Text(f"foreign page {origin}", f"посторонняя страница {origin}")
                )
        site = headers.get("sec-fetch-site", "none")
        opened = headers.get("sec-fetch-mode") == "navigate" and request["path"] == "/"
        if site not in ("none", "same-origin") and not opened:
            raise Forbidden(
                problem=Text("a request of another site's page", "запрос со страницы другого сайта")
            )

    def _has_token(self, request: HTTPConnection) -> bool:
        scheme, _, given = request.headers.get("authorization", "").partition(" ")
        if scheme.lower() == "bearer" and self._is_token(given.strip()):
            return True
        if self._is_token(request.cookies.get(self.cookie, "")):
            return True
        given = request.query_params.get("token", "")
        return request["type"] == "websocket" and self._is_token(given)

    def _is_token(self, given: str) -> bool:
        return hmac.compare_digest(given.encode(), self.token.encode())


def check_from_network(url: str, find: Callable[[], list[Port]]) -> None:
    """Raise `NotFromNetwork`, `BadPortUrl` for a port that the network may not name."""
    if not (_is_shipped_car(url) or url in [port.url for port in find()]):
        raise NotFromNetwork(url=url)


def _new_token() -> str:
    return secrets.token_urlsafe(18)


def is_encrypted(scope: Scope) -> bool:
    """Whether the request came over TLS."""
    return scope.get("scheme") in ("https", "wss")


def _host(request: HTTPConnection) -> str:
    """Return the request's host, an IPv6 address in its shortest form, as browsers write it."""
    host = request.headers.get("host", "").lower()
    number, closing, rest = host.removeprefix("[").partition("]")
    if host.startswith("[") and closing and is_ipv6(number) and is_number(number):
        return f"[{ipaddress.ip_address(number)}]{rest}"
    return host


def _is_shipped_car(url: str) -> bool:
    from mikas.virtual.scenarios.scenario import SCENARIOS  # late: most users have a cable

    parsed = parse(url)
    return (
        parsed.scheme == "sim"
        and not parsed.address
        and set(parsed.options) <= _CAR_OPTIONS
        and parsed.options.get("scenario", next(iter(SCENARIOS))) in SCENARIOS
    )
