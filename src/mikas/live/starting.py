"""`session`: from a port and channels to a `Session`; `prepared`: the same for the commands."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from os import PathLike
from pathlib import Path
from typing import Final, Unpack

from mikas.catalog import Catalog, load
from mikas.client.connecting import ConnectionKeywords, ConnectionOptions, StrPath, named_port
from mikas.client.parameters.polling import Method
from mikas.errors import CaptureError, usage_error
from mikas.instruments.choosing import ChosenInstrument, check_beside, chosen_instruments
from mikas.instruments.places import likely_beside
from mikas.instruments.session_instruments import SessionInstruments
from mikas.link import Link, choose_port, find_ports, open_link
from mikas.link.reconnecting import ReconnectingPort
from mikas.live.progress import Length
from mikas.live.session import Session, listed
from mikas.recording.capture.instruments import CONNECTED, instrument_port, loss
from mikas.recording.recorder import Recorder
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.fault_watch import IN_STREAMS
from mikas.sampling.plan import Selection
from mikas.sampling.session import SamplingSession

_OWN: Final = "own-link"  # the name of a port that `open_port` opens, in messages


def prepared(
    port: str,
    connection: ConnectionOptions,
    channels: Iterable[str],
    length: Length,
    *,
    method: str = "auto",
    recorder: Recorder,
    record: Path | None = None,
    on_record_failure: Callable[[CaptureError], object] | None = None,
    keeps_unanswered: bool = False,
    wants_faults: Callable[[], bool] = lambda: True,
    in_streams: float | None = IN_STREAMS,
    patient: bool = False,
    open_port: Callable[[str], Link] = open_link,
    instruments: Sequence[ChosenInstrument] = (),
    open_instrument: Callable[[str], Link] = open_link,
) -> Session:
    """Prepare a session with these parts. `in_streams`: as of `FaultWatch`.

    `keeps_unanswered`: a recording in which no unit has answered stays. The other
    arguments and the errors: as of `session`. `open_instrument`: opens the instruments' ports.
    """
    check_beside(port, instruments)
    reconnecting = ReconnectingPort(
        port, open_port=open_port, sink=recorder, timeout=connection.timeout
    )
    recorder.instruments = tuple(
        instrument_port(each.definition, each.url, each.label) for each in instruments
    )
    beside = None
    if instruments:
        beside = SessionInstruments(
            instruments, reconnecting, recorder, (CONNECTED, loss), open_port=open_instrument
        )
    acquisition = Acquisition(
        reconnecting,
        connection.create_ecu,
        connection.catalog,
        _of_the_unit(channels, connection.catalog, instruments),
        method=method,
        rate=length.rate,
        strict=not patient,
    )
    _check_inputs(acquisition.selection, instruments)
    sampling = SamplingSession(recorder.record_event, in_streams=in_streams)
    sampling.wants_faults = wants_faults
    made = Session(
        acquisition,
        recorder,
        sampling,
        length,
        on_record_failure=on_record_failure,
        keeps_unanswered=keeps_unanswered,
        instruments=beside,
    )
    if record is not None:
        recorder.start(record, url=port)
    return made


def _of_the_unit(
    names: Iterable[str], catalog: Catalog, instruments: Sequence[ChosenInstrument]
) -> list[str]:
    """Return `names` without those of the instruments, which each sample has unasked.

    Raises `UsageError` if none is left: no name stands for all parameters of the unit.
    """
    names = list(names)
    beside = catalog.with_beside(channel for each in instruments for channel in each.channels)
    kept = [
        name
        for name in names
        if not (isinstance(name, str) and beside.input_of(name.partition("/")[0]) in beside.beside)
    ]
    if names and not kept:
        listed_names = ", ".join(names)
        raise usage_error(
            f"{listed_names}: an instrument gives it at the unit's samples; name a parameter of "
            "the unit as well, as in FREQ",
            f"{listed_names}: это канал прибора, его значения идут вместе с опросом блока; "
            "назовите и параметр блока, например FREQ",
        )
    return kept


def _check_inputs(selection: Selection, instruments: Sequence[ChosenInstrument]) -> None:
    """Raise `UsageError` for a derived channel that needs an instrument which is not there."""
    given = {channel.name for each in instruments for channel in each.channels}
    for name in selection.derived:
        for needed in selection.catalog.required_beside([name]):
            if needed not in given:
                raise usage_error(
                    f"{name} needs {needed}, which no instrument of this session gives; add one, "
                    "as in --instrument aem=/dev/ttyUSB1",
                    f"Каналу {name} нужен {needed}, а прибора, который его даёт, нет; добавьте "
                    "его, например --instrument aem=/dev/ttyUSB1",
                )


def _port(open_port: Callable[[str], Link], beside: Sequence[str]) -> str:
    """Return the port that the user has set, else the only one at which no instrument is.

    `open_port` may need none. `beside`: the instruments' ports.
    """
    if named := named_port():
        return named
    if open_port is not open_link:
        return _OWN
    return likely_beside(beside, find_ports()) if beside else choose_port()


def session(
    url: str | None = None,
    channels: str | Iterable[str] = (),
    *,
    method: Method = "auto",
    rate: float | None = None,
    count: int | None = None,
    duration: float | None = None,
    record: StrPath | None = None,
    on_record_failure: Callable[[CaptureError], object] | None = None,
    faults: bool = True,
    patient: bool = False,
    catalogs: StrPath | Iterable[StrPath] = (),
    open_port: Callable[[str], Link] = open_link,
    instruments: str | Iterable[str] = (),
    **options: Unpack[ConnectionKeywords],
) -> Session:
    """Prepare a session; its port is opened when it is iterated.

    `url`: as of `connect`. `channels`: names, codes (`0x1A`) and derived channels, each with `/10`
    for every tenth cycle; none: all parameters. The parameters that a derived channel needs are
    sampled with it. `method`: auto is the fastest that works. `rate`: most samples a second.
    `record`: the recording's file, which must not exist; if it fails, `on_record_failure` gets the
    error and sampling goes on, else it is raised. `faults`: read the stored faults from time to
    time. `patient`: wait for the first port and unit as well. `catalogs`: the user's own files.
    `open_port`: opens the port, for tests and links of your own; it gets `url`, and is called again
    after a loss. `instruments`: λ meters and GPS receivers beside the unit, as
    `aem=/dev/ttyUSB1`, `gpsd=gpsd:localhost:2947` or, at a virtual unit, `nmea=sim:`; a sample has
    their values, named in `channels` or not, a recording their bytes, and their errors never stop
    it. The other `options` are those of `ConnectionOptions`.

    Raises `UsageError` for an invalid option, `UnknownParameter`, `CaptureError` for the file.
    """
    if not isinstance(url, str | None):
        raise TypeError(
            f"url is the address of a port, not {url!r}. A link of your own is opened by "
            "open_port=lambda url: …, also again after a loss"
        )
    files = [catalogs] if isinstance(catalogs, str | PathLike) else catalogs
    connection = ConnectionOptions(catalog=load(*files), **options)
    beside = chosen_instruments(listed(instruments), connection.catalog)
    return prepared(
        _port(open_port, [each.url for each in beside]) if url is None else url,
        connection,
        listed(channels),
        Length(count, duration, rate),
        method=method,
        recorder=Recorder(interpretation=connection.interpretation),
        record=None if record is None else Path(record),
        on_record_failure=on_record_failure,
        wants_faults=lambda: faults,
        patient=patient,
        open_port=open_port,
        instruments=beside,
    )
