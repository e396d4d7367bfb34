"""`--instrument aem=/dev/ttyUSB1`: which instruments a session has, and at which ports."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final
from urllib.parse import parse_qsl

from mikas.catalog import Catalog, InstrumentChannel
from mikas.cleaning import public_port
from mikas.errors import UsageError, usage_error
from mikas.instruments.definition import InstrumentDefinition
from mikas.instruments.loading import definition_named, definition_names
from mikas.instruments.places import GPSD, SIM, at_one_port
from mikas.link.urls import bad_port_url, parse
from mikas.options import OptionParser

_LABEL: Final = re.compile(r"([A-Za-z][A-Za-z0-9_]{1,19}):(.+)")  # C:\my.toml has none
_MOST: Final = 16
_GPSD_BAUD: Final = 1_000_000  # more than it sends is no GPS


@dataclass(frozen=True, slots=True)
class ChosenInstrument:
    """An instrument of a session. `label`: the end of its channels' names; or empty."""

    definition: InstrumentDefinition
    """What it is."""
    url: str
    """Its port: as of a unit, `gpsd:HOST:PORT`, or `sim:`."""
    label: str = ""

    @property
    def channels(self) -> tuple[InstrumentChannel, ...]:
        """Its channels, with the label at the end of their names."""
        return self.definition.labelled(self.label).channels

    @property
    def title(self) -> str:
        """The name for a person's eyes: `left:aem`."""
        return f"{self.label}:{self.definition.name}" if self.label else self.definition.name


def chosen_instruments(texts: Iterable[str], catalog: Catalog) -> tuple[ChosenInstrument, ...]:
    """Return the instruments that texts `[LABEL:]NAME=URL` name. NAME: a definition, or a file.

    Raises `UsageError` for a text in another form, an unknown instrument, two at one port or with a
    channel of one name; `CatalogError` for a wrong file; `BadPortUrl`.
    """
    found = tuple(_chosen(text, catalog) for text in texts)
    check_together(found, catalog)
    return found


def check_together(chosen: Iterable[ChosenInstrument], catalog: Catalog) -> None:
    """Raise `UsageError` for too many, two at one port, and two with a channel of one name."""
    owners: dict[str, ChosenInstrument] = {}
    before: list[ChosenInstrument] = []
    for one in chosen:
        for other in before:
            if at_one_port(one.url, other.url):
                port = public_port(one.url)
                raise usage_error(
                    f"{one.title}: {other.title} is at the port {port}; each instrument needs a "
                    "port of its own",
                    f"{one.title}: на порту {port} уже {other.title}; каждому прибору нужен свой "
                    "порт",
                )
        before.append(one)
        text = f"{one.title}={public_port(one.url)}"
        for channel in one.channels:
            if channel.name in catalog.channels:
                raise usage_error(
                    f"{one.title}: {channel.name} is a channel of the unit; give another label",
                    f"{one.title}: {channel.name} — канал самого блока; дайте другую метку",
                )
            if (other := owners.setdefault(channel.name, one)) is not one:
                first = f"{other.title}={public_port(other.url)}"
                raise usage_error(
                    f"Two instruments give {channel.name}: {first} and {text}; label one of them: "
                    f"--instrument rear:{text}",
                    f"Канал {channel.name} дают два прибора: {first} и {text}; дайте одному метку: "
                    f"--instrument rear:{text}",
                )
    if len(before) > _MOST:
        raise usage_error(
            f"More than {_MOST} instruments; leave some out",
            f"Больше {_MOST} приборов; уберите лишние",
        )


def check_beside(unit: str, chosen: Iterable[ChosenInstrument]) -> None:
    """Raise `UsageError` for an instrument at the port of the unit, whose line it would disturb."""
    for one in chosen:
        if at_one_port(one.url, unit):
            port = public_port(unit)
            raise usage_error(
                f"{one.title}: the unit itself is at {port}; an instrument needs a port of its own",
                f"{one.title}: на порту {port} сам блок; прибору нужен свой порт",
            )


def _chosen(text: str, catalog: Catalog) -> ChosenInstrument:
    name, equals, url = text.partition("=")
    name, url = name.strip(), url.strip()
    if not equals or not name or not url:
        raise usage_error(
            f"Write NAME=URL, not “{text}”: aem=/dev/ttyUSB1, nmea=COM4, gpsd=gpsd:localhost:2947",
            f"Пишите NAME=URL, а не «{text}»: aem=/dev/ttyUSB1, nmea=COM4, "
            "gpsd=gpsd:localhost:2947",
        )
    match = _LABEL.fullmatch(name)
    label, name = match.groups() if match else ("", name)
    definition = definition_named(name, catalog)
    if name.lower().endswith(".toml") and definition.name in definition_names():
        raise usage_error(
            f"{name}: there is an instrument “{definition.name}” already, by which a recording "
            f"would be read; name the file my-{definition.name}.toml",
            f"{name}: прибор «{definition.name}» уже есть, и запись читалась бы по нему; назовите "
            f"файл my-{definition.name}.toml",
        )
    return placed(definition, url, label, catalog)


def placed(
    definition: InstrumentDefinition, url: str, label: str, catalog: Catalog
) -> ChosenInstrument:
    """Return the instrument at `url`. Raises `UsageError`, `BadPortUrl` for a wrong one."""
    if url.lower().startswith(GPSD):
        name = definition.name
        if definition.decoder == "nmea":  # the receiver is the same one, its language gpsd's
            definition = definition_named("gpsd", catalog)
        if definition.decoder != "gpsd":
            raise usage_error(
                f"gpsd serves GPS receivers, not “{name}”: gpsd={url}",
                f"Через gpsd работают приёмники GPS, а не «{name}»: gpsd={url}",
            )
        parse(network_url(url))
    elif url.lower().startswith(SIM):
        _check_virtual(definition, url)
    else:
        _check_speed(url, definition)
        if definition.decoder == "gpsd":
            raise usage_error(
                "gpsd is reached by its own address, gpsd=gpsd:localhost:2947; a receiver at a "
                f"port of its own is nmea={public_port(url)}",
                "gpsd доступен по своему адресу, gpsd=gpsd:localhost:2947; приёмник на отдельном "
                f"порту — nmea={public_port(url)}",
            )
    return ChosenInstrument(definition, url, label)


def _check_virtual(definition: InstrumentDefinition, url: str) -> None:
    from mikas.virtual.instruments import check_virtual_instrument  # the engine: for this only

    if url.lower() != SIM:
        raise usage_error(
            "As an instrument's port sim: has no options: they belong to the car, at --port",
            "У sim: как порта прибора нет параметров: они задаются машине, в --port",
        )
    check_virtual_instrument(definition.name)


def _check_speed(url: str, definition: InstrumentDefinition) -> None:
    """Raise `BadPortUrl` for a speed that no port has: the times of bytes are counted by it."""
    options = OptionParser(parse(url).options)
    try:
        options.integer("baud", definition.baud, lowest=50, highest=4_000_000)
    except UsageError as error:
        raise bad_port_url(url, error.reason) from error


def line_baud(definition: InstrumentDefinition, url: str) -> int:
    """Return the bits a second of an instrument's line: its URL's, else its definition's."""
    if url.lower().startswith(GPSD):
        return _GPSD_BAUD
    given = dict(parse_qsl(url.partition("?")[2])).get("baud", "")
    return int(given) if given.isdecimal() and len(given) < 8 else definition.baud


def network_url(url: str) -> str:
    """Return the URL of gpsd's TCP port: `socket://localhost:2947` of `gpsd:` or `gpsd:HOST`."""
    host, _, port = url[len(GPSD) :].removeprefix("//").rpartition(":")
    if not port.isdecimal():
        host, port = (f"{host}:{port}" if host else port), "2947"
    return f"socket://{host or 'localhost'}:{port}"
