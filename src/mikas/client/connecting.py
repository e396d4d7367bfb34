"""`connect`: from a port's URL to an `Ecu`."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from math import inf
from pathlib import Path

from mikas.catalog import INTERPRETATIONS, Catalog, load
from mikas.client import journal as journals
from mikas.client import limits as stores
from mikas.client.ecu import Ecu
from mikas.client.gate import Confirm
from mikas.client.journal import Journal
from mikas.client.limits import LimitsStore
from mikas.errors import UsageError
from mikas.i18n import Text
from mikas.link import CaptureTee, Link, Sink, choose_port, open_link
from mikas.tester import Echo, Tester, Timing


def connect(
    url: str | None = None,
    *,
    echo: str = "auto",
    timeout: float = 0.5,
    inter_byte_timeout: float = 0.02,
    retries: int = 2,
    interpretation: str = "corrected",
    catalogs: Iterable[Path] = (),
    confirm: Confirm | None = None,
    journal: Path | None = None,
    state: Path | None = None,
    sink: Sink | None = None,
    raw_checksum: bool = False,
    strict: bool = False,
) -> Ecu:
    """Opens the port, finds the ECU on it and returns it, ready to be asked.

    `url`: `/dev/ttyUSB0`, `COM3`, `socket://host:port`, `rfc2217://host:port`, `sim:`; none: the
    one likely adapter that is plugged in. `echo`: auto, on or off (D1). `timeout`: seconds to the
    first byte of a response, `inter_byte_timeout`: to each further one (D14). `retries`: how often
    a request that changes nothing is sent again after a spoilt exchange. `interpretation`:
    corrected, literal or alternative (errata). `catalogs`: the user's own files. `confirm`: asked
    before every change; without it every change passes but the dangerous ones. `journal`: file of
    changes, by default in the user's state folder. `state`: folder of learnt limits, likewise.
    `sink`: gets everything that passes on the wire. `raw_checksum`: send a checksum 0D or 40 as it
    is (D3). `strict`: a lone escape is damage (D4).

    Raises `NoConnection` or a `LineError` with what to try; before the port is opened, `UsageError`
    for settings that make no sense.
    """
    make_ecu = ecu_factory(
        echo=echo,
        timeout=timeout,
        inter_byte_timeout=inter_byte_timeout,
        retries=retries,
        interpretation=interpretation,
        catalog=load(*catalogs),
        confirm=confirm,
        journal=journal,
        state=state,
        raw_checksum=raw_checksum,
        strict=strict,
    )
    link: Link = open_link(choose_port() if url is None else url)
    if sink is not None:
        link = CaptureTee(link, sink)
    try:
        ecu = make_ecu(link)
        ecu.tester.connect()
    except BaseException:
        link.close()
        raise
    return ecu


def ecu_factory(
    *,
    echo: str = "auto",
    timeout: float = 0.5,
    inter_byte_timeout: float = 0.02,
    retries: int = 2,
    interpretation: str = "corrected",
    catalogs: Iterable[Path] = (),
    catalog: Catalog | None = None,
    confirm: Confirm | None = None,
    journal: Path | None = None,
    state: Path | None = None,
    raw_checksum: bool = False,
    strict: bool = False,
) -> Callable[[Link], Ecu]:
    """What makes an `Ecu` of an open link, not yet connected; for links that come and go.

    The settings are those of `connect`, checked here: raises `UsageError`. `catalog`: definitions
    that are loaded already, instead of `catalogs`.
    """
    _check_choice("echo", echo, [it.value for it in Echo])
    _check_choice("interpretation", interpretation, INTERPRETATIONS)
    _check_number("timeout", timeout, lowest=0.001)
    _check_number("inter_byte_timeout", inter_byte_timeout, lowest=0.001)
    _check_number("retries", retries, lowest=0)
    if not isinstance(retries, int):
        raise _bad("retries", retries, Text("a whole number", "целое число"))
    definitions = load(*catalogs) if catalog is None else catalog
    changes = Journal(Path(journal or journals.default_path()))
    store = LimitsStore(Path(state or stores.default_folder()))

    def make_ecu(link: Link) -> Ecu:
        tester = Tester(
            link,
            timing=Timing(response_timeout=timeout, inter_byte_timeout=inter_byte_timeout),
            echo=Echo(echo),
            retries=retries,
            raw_checksum=raw_checksum,
            strict=strict,
        )
        return Ecu(
            tester,
            definitions,
            interpretation=interpretation,
            confirm=confirm,
            journal=changes,
            store=store,
        )

    return make_ecu


def _check_choice(name: str, value: str, allowed: Iterable[str]) -> None:
    if value not in allowed:
        listed = ", ".join(allowed)
        raise _bad(name, value, Text(listed, listed))


def _check_number(name: str, value: float, *, lowest: float) -> None:
    if isinstance(value, bool) or not isinstance(value, int | float) or not lowest <= value < inf:
        raise _bad(name, value, Text(f"a number from {lowest:g} up", f"число от {lowest:g}"))


def _bad(name: str, value: object, allowed: Text) -> UsageError:
    return UsageError(
        problem=Text(
            f"“{value}” is no value for {name}; allowed: {allowed.en}",
            f"«{value}» не подходит для {name}; можно: {allowed.ru}",
        )
    )
