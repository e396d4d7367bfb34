"""`connect`: from a port's URL to an `Ecu`."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from mikas.catalog import load
from mikas.client import journal as journals
from mikas.client import limits as stores
from mikas.client.ecu import Ecu
from mikas.client.gate import Confirm
from mikas.client.journal import Journal
from mikas.client.limits import LimitsStore
from mikas.link import CaptureTee, Link, Sink, choose_port, open_link
from mikas.tester import Echo, Tester, Timing


def connect(
    url: str | None = None,
    *,
    echo: str = "auto",
    timeout: float = 0.5,
    retries: int = 2,
    reading: str = "corrected",
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
    first byte of a response (D14). `reading`: corrected, literal or alternative (errata).
    `catalogs`: the user's own files. `confirm`: asked before every change. `journal`: file of
    changes, by default in the user's state folder. `state`: folder of learnt limits, likewise.
    `sink`: gets everything that passes on the wire. `raw_checksum`: send a checksum 0D or 40 as it
    is (D3).

    Raises `NoConnection` with what to try, `UsageError` for settings that make no sense.
    """
    catalog = load(*catalogs)
    link: Link = open_link(url or choose_port())
    if sink is not None:
        link = CaptureTee(link, sink)
    try:
        tester = Tester(
            link,
            timing=Timing(first_byte=timeout),
            echo=Echo(echo),
            retries=retries,
            raw_checksum=raw_checksum,
            strict=strict,
        )
        ecu = Ecu(
            tester,
            catalog,
            reading=reading,
            confirm=confirm,
            journal=Journal(journal or journals.default_path()),
            store=LimitsStore(state or stores.default_folder()),
        )
        tester.connect()
    except BaseException:
        link.close()
        raise
    return ecu
