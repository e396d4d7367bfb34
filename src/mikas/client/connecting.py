"""`connect`: from a port's URL to an `Ecu`, and the options of a connection."""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, TypedDict

from mikas import home
from mikas.catalog import Catalog, Interpretation, load, shipped
from mikas.catalog.model import check_interpretation
from mikas.client.ecu import Ecu
from mikas.client.gate import Confirm
from mikas.client.limits import LimitsStore
from mikas.errors import usage_error
from mikas.link import CaptureTee, Link, Sink, choose_port, open_link
from mikas.link.interface import check_link
from mikas.options import check_choice, check_number, invalid_value
from mikas.tester import Echo, Tester, Timing
from mikas.tester.pauses import LONGEST_PAUSE

PauseSetting = float | Literal["auto"]
"""The least seconds from a response to the next request (D14); auto: found by trying, if needed."""
StrPath = str | os.PathLike[str]
EchoSetting = Literal["auto", "on", "off"]
"""Whether the adapter returns what it sends (D1); auto: the first exchange shows it."""

STATE_VARIABLE = "MIKAS_STATE"
PORT_VARIABLE = "MIKAS_PORT"
_SHORTEST = 0.001  # s; a shorter time-out would end before an adapter hands over its first byte


@dataclass(frozen=True, slots=True, kw_only=True)
class ConnectionOptions:
    """Options of a connection on any port. Raises `UsageError` for an invalid value.

    `create_ecu` may be called for each new link after a lost one.
    """

    echo: EchoSetting = "auto"
    """auto, on or off: whether the adapter returns what it sends (D1)."""

    timeout: float = 0.5
    """Seconds from the end of a request to the first byte of its response (D14)."""

    inter_byte_timeout: float = 0.2
    """Seconds of silence inside a response after which it counts as cut (D14)."""

    retries: int = 2
    """How often a request that changes nothing is repeated after a failed exchange."""

    pause: PauseSetting = "auto"
    """The least seconds from a response to the next request (D14). auto: 0, unless the unit is
    found to answer no request that follows a response sooner; this is remembered of it."""

    interpretation: Interpretation = "corrected"
    """corrected, literal, alternative or family: the interpretation of the source's errata."""

    catalog: Catalog = field(default_factory=shipped)
    """The definitions of parameters, faults and models."""

    confirm: Confirm | None = None
    """Asked before every change, answers True or False; None: every change passes but the dangerous
    ones (`Safety.DANGEROUS`: writes to CODE, and 41)."""

    journal: StrPath | None = None
    """The file of changes; None: the one in `state_folder()`, of a virtual unit none unless
    MIKAS_STATE names the folder."""

    state: StrPath | None = None
    """The folder of learnt limits and lists; None: `units` in `state_folder()`, without the limits
    of virtual units unless MIKAS_STATE names it."""

    raw_checksum: bool = False
    """Send a checksum 0D or 40 as it is (D3)."""

    strict: bool = False
    """Treat a lone escape as damage (D4)."""

    virtual_units: bool | None = None
    """Whether limits of virtual units are kept; None: in a folder that was named."""

    def __post_init__(self) -> None:
        if inspect.iscoroutinefunction(self.confirm):
            raise TypeError("confirm is an async function, which only AsyncEcu awaits")
        if self.confirm is not None and not callable(self.confirm):
            raise TypeError(
                f"confirm is a function that returns True or False, not {self.confirm!r}"
            )
        check_choice("echo", self.echo, [echo.value for echo in Echo])
        check_interpretation(self.interpretation)
        check_number("timeout", self.timeout, lowest=_SHORTEST)
        check_number("inter_byte_timeout", self.inter_byte_timeout, lowest=_SHORTEST)
        check_number("retries", self.retries, lowest=0, whole=True)
        if self.pause != "auto":
            check_pause(self.pause)

    def create_ecu(self, link: Link) -> Ecu:
        """Create an `Ecu` on `link`; it is not connected yet: `ecu.tester.connect()` does that."""
        tester = Tester(
            link,
            timing=Timing(
                response_timeout=self.timeout, inter_byte_timeout=self.inter_byte_timeout
            ),
            echo=Echo(self.echo),
            retries=self.retries,
            pause=None if self.pause == "auto" else self.pause,
            raw_checksum=self.raw_checksum,
            strict=self.strict,
        )
        return Ecu(
            tester,
            self.catalog,
            interpretation=self.interpretation,
            confirm=self.confirm,
            journal=self._journal(link),
            store=self._store(link),
            lists=self._lists(link),
        )

    def _journal(self, link: Link) -> Path | None:
        if self.journal is not None:
            return Path(self.journal)
        if link.is_virtual and not os.environ.get(STATE_VARIABLE):
            return None  # the user's own journal is of cars
        return state_folder() / "journal.jsonl"

    def _lists(self, link: Link) -> Path | None:
        if link.is_virtual and self.state is None and not os.environ.get(STATE_VARIABLE):
            return None  # the next virtual unit has no list
        return Path(self.state or state_folder() / "units") / "lists"

    def _store(self, link: Link) -> LimitsStore | None:
        kept = self.virtual_units
        if kept is None:
            kept = self.state is not None or bool(os.environ.get(STATE_VARIABLE))
        if link.is_virtual and not kept:
            return None
        return LimitsStore(Path(self.state or state_folder() / "units"), virtual_units=kept)


class ConnectionKeywords(TypedDict, total=False):
    """The fields of `ConnectionOptions` but the catalog, as keyword arguments of a function."""

    echo: EchoSetting
    timeout: float
    inter_byte_timeout: float
    retries: int
    pause: PauseSetting
    interpretation: Interpretation
    confirm: Confirm | None
    journal: StrPath | None
    state: StrPath | None
    raw_checksum: bool
    strict: bool
    virtual_units: bool | None


def check_pause(value: object) -> None:
    """Raise `UsageError` unless `value` is a pause in seconds."""
    seconds = value if isinstance(value, int | float) and not isinstance(value, bool) else -1
    if not 0 <= seconds <= LONGEST_PAUSE:
        raise invalid_value("pause", value, f"auto, 0 … {LONGEST_PAUSE:g}")


def state_folder() -> Path:
    """Return the folder of the journal and of learnt limits: MIKAS_STATE, or the user's own."""
    if named := os.environ.get(STATE_VARIABLE):
        return Path(named)
    return home.state_folder()


def connect(
    url: str | None = None,
    *,
    link: Link | None = None,
    echo: EchoSetting = "auto",
    timeout: float = 0.5,
    inter_byte_timeout: float = 0.2,
    retries: int = 2,
    pause: PauseSetting = "auto",
    interpretation: Interpretation = "corrected",
    catalogs: StrPath | Iterable[StrPath] = (),
    confirm: Confirm | None = None,
    journal: StrPath | None = None,
    state: StrPath | None = None,
    sink: Sink | None = None,
    on_sink_failure: Callable[[Exception], None] | None = None,
    raw_checksum: bool = False,
    strict: bool = False,
) -> Ecu:
    """Open the port, find the ECU on it and return it, ready for requests.

    `url`: `/dev/ttyUSB0`, `COM3`, `socket://host:port`, `rfc2217://host:port`, `sim:`; None: that
    of MIKAS_PORT, else of the config file, else the only likely adapter. `link`: an open link of
    your own instead, of the interface of `mikas.link.Link`; it is closed with the unit.
    `catalogs`: the user's own files. `sink`: records all bytes on the wire; if it fails,
    `on_sink_failure` gets its exception and the session goes on unrecorded; None: the exception is
    raised, and by each later request again.

    `confirm`: asked before each change of the unit; True makes it, False raises `NotConfirmed`.
    Without it every change is made at once but writes to CODE and `goto` (41), which are refused.
    The other options: `ConnectionOptions`. Raises `UsageError` for an invalid option before the
    port is opened, then `NoConnection` or a `LineError`.
    """
    options = ConnectionOptions(
        echo=echo,
        timeout=timeout,
        inter_byte_timeout=inter_byte_timeout,
        retries=retries,
        pause=pause,
        interpretation=interpretation,
        catalog=load(*([catalogs] if isinstance(catalogs, str | os.PathLike) else catalogs)),
        confirm=confirm,
        journal=journal,
        state=state,
        raw_checksum=raw_checksum,
        strict=strict,
    )
    if isinstance(link, str):
        raise TypeError(f"link is an open link; an address comes first: connect({link!r})")
    if link is not None:
        check_link(link, "link")
    if link is not None and url is not None:
        raise usage_error(
            "connect() takes a url or a link, not both",
            "connect() принимает или url, или link, но не оба",
        )
    return open_ecu(
        url if link is None else link,
        options,
        sink=sink,
        on_sink_failure=on_sink_failure or _refuse,
    )


def named_port() -> str:
    """Return the port of MIKAS_PORT, else of the config file; empty if neither names one.

    Raises `UsageError` for a wrong config file.
    """
    if named := os.environ.get(PORT_VARIABLE, "").strip():
        return named
    from mikas.preferences import A_PORT, config_path, parsed_config, wrong_config

    port = parsed_config(config_path()).get("port", "")
    if not isinstance(port, str):
        raise wrong_config(config_path(), f"port has to be {A_PORT.en}", f"port — это {A_PORT.ru}")
    return port.strip()


def _refuse(error: Exception) -> None:
    raise error


def open_ecu(
    port: Link | str | None,
    options: ConnectionOptions,
    *,
    sink: Sink | None = None,
    on_sink_failure: Callable[[Exception], None] = _refuse,
) -> Ecu:
    """As `connect`, with the options as one value."""
    if port is None:
        port = named_port() or choose_port()
    link = open_link(port) if isinstance(port, str) else port
    check_link(link, "what connect() gets")
    if sink is not None:
        link = CaptureTee(link, sink, on_failure=on_sink_failure)
    try:
        ecu = options.create_ecu(link)
        ecu.tester.connect()
    except BaseException:
        link.close()
        raise
    return ecu
