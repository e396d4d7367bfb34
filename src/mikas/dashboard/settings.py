"""The settings of the server: connection options, folders, and how ports are opened.

And the two requests that outlive a connection: the port, and the channels to sample.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from mikas.catalog.own.file import NAME, OwnCatalog
from mikas.cleaning import public_port
from mikas.client.connecting import (
    STATE_VARIABLE,
    ConnectionOptions,
    EchoSetting,
    PauseSetting,
    state_folder,
)
from mikas.client.parameters.polling import Method
from mikas.dashboard.network.addresses import own_addresses
from mikas.errors import (
    UsageError,
    reason_of,
    system_error,
)
from mikas.i18n import Language, Text
from mikas.link import Link, Port, WallClock, find_ports, open_link
from mikas.link.urls import parse

if TYPE_CHECKING:
    from mikas.virtual.bus import Bus

_ELSEWHERE = Text(
    "Start the dashboard again with --record and a writable folder.",
    "Запустите панель снова с ключом --record и папкой, доступной для записи.",
)


def ensure_folder(folder: Path) -> Path:
    """Create `folder` if it is missing, and return it. Raises `UsageError`."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        why = reason_of(error)
        failed = UsageError(
            problem=Text(
                f"The folder {folder} can't be created: {why.en}",
                f"Не удаётся создать папку {folder}: {why.ru}",
            ),
            advice=_ELSEWHERE,
        )
        raise failed.caused_by(error, folder) from error
    return folder


def folder_error(folder: Path) -> UsageError | None:
    """Return why `folder` is not writable; None: it is. Creates nothing."""
    there = folder
    while not os.path.lexists(there) and there != there.parent:
        there = there.parent
    if there.is_dir() and os.access(there, os.W_OK | os.X_OK):
        return None
    code = errno.EACCES if there.is_dir() else errno.ENOTDIR
    refusal = system_error(code)
    why = reason_of(refusal)
    failed = UsageError(
        problem=Text(
            f"The folder {folder} is not writable ({there}: {why.en})",
            f"В папку {folder} нельзя записать ({there}: {why.ru})",
        ),
        advice=_ELSEWHERE,
    )
    return failed.caused_by(refusal, folder)


@dataclass(frozen=True, slots=True)
class Settings:
    """`recordings`: the folder of recordings, with `dumps` in it. `state`: presets, learnt limits,
    the journal; None: `state_folder()`. `find`, `open_port`, `wall`: the system's ports, and one
    clock for all connections, so that a date that is set moves none against another; tests replace
    them. `own`: the user's own catalog, which the dashboard may
    change; None: one in the folder of the state, which other commands do not read.
    """

    recordings: Path
    state: Path | None = None
    connection: ConnectionOptions = field(default_factory=ConnectionOptions)
    find: Callable[[], list[Port]] = find_ports
    open_port: Callable[[str], Link] = open_link
    wall: WallClock = field(default_factory=WallClock)
    addresses: Callable[[], tuple[str, ...]] = own_addresses
    """This computer's addresses and names in the network."""
    language: Language | None = None
    """The page's language until the user chooses one there; None: the browser's."""
    own: OwnCatalog | None = None
    tests: Path | None = None
    """The folder of the user's guided tests; None: only the shipped ones."""
    causes: Path | None = None
    """The folder of the user's causes; None: only the shipped ones."""
    desktop: bool = False
    """Whether an icon has started the program: no terminal ends it (`mikas.dashboard.program`)."""
    made_again: Path | None = None
    """The folder of what can be made again; None: that of the state."""
    sockets: bool = True
    """Whether the program reaches a network: MQTT and webhooks; not so in a browser."""

    @property
    def _state(self) -> Path:
        return self.state or state_folder()

    @property
    def own_catalog(self) -> OwnCatalog:
        """The user's own catalog."""
        return self.own or OwnCatalog(self._state / NAME)

    @property
    def journal(self) -> Path:
        """The file of the journal."""
        return self._state / "journal.jsonl"

    @property
    def units(self) -> Path | None:
        """The folder of learnt limits, a file per unit; None as in `ConnectionOptions.state`."""
        return None if self.state is None else self.state / "units"

    def in_state(self, name: str) -> Path:
        """Return the file or folder of that name in the folder of the state."""
        return self._state / name

    @property
    def virtual_recordings(self) -> Path:
        """The folder of recordings of the virtual car."""
        return (self.made_again or self._state) / "virtual"

    @property
    def virtual_units(self) -> bool:
        """Whether data of virtual units are kept."""
        if (chosen := self.connection.virtual_units) is not None:
            return chosen
        return self.state is not None or bool(os.environ.get(STATE_VARIABLE))

    @property
    def certificate(self) -> Path:
        """The file of the certificate, with its key, for the network."""
        return self._state / "dashboard.pem"

    @property
    def dumps(self) -> Path:
        """The folder of dumps."""
        return self.recordings / "dumps"

    @property
    def surveys(self) -> Path:
        """The folder of surveys for the project."""
        return self.recordings / "surveys"


@dataclass(frozen=True, slots=True)
class PortSettings:
    """How the unit is reached."""

    url: str
    echo: EchoSetting = "auto"
    pause: PauseSetting | None = None
    """None: as in the settings of the program."""

    @property
    def shown(self) -> str:
        """The URL for every client, without a password."""
        return public_port(self.url)

    def applied(self, options: ConnectionOptions) -> ConnectionOptions:
        """Return the options of the program with those of this port."""
        pause = options.pause if self.pause is None else self.pause
        return replace(options, echo=self.echo, pause=pause)


@dataclass(frozen=True, slots=True)
class PlanSettings:
    """The channels to sample. `every`: a divisor for each name; 10 means every tenth cycle.

    `first`: those that come first where each channel costs time (`Acquisition.prefer`).
    """

    every: dict[str, int]
    method: Method = "auto"
    rate: float | None = None
    first: tuple[str, ...] = ()

    @property
    def names(self) -> list[str]:
        """As `Acquisition` takes them: `TWAT/10`."""
        return [name if every == 1 else f"{name}/{every}" for name, every in self.every.items()]


class VirtualCars:
    """Opens ports; in real time, the same `sim:` URL leads to the same virtual car.

    After a disconnect or a diagnosis the car is still there: erased faults stay erased, and the
    engine is as warm as it is by now.
    """

    def __init__(self, open_port: Callable[[str], Link] = open_link) -> None:
        self._open_port = open_port
        self._cars: dict[str, Bus] = {}

    def open(self, url: str) -> Link:
        """Open a port, as `open_link`."""
        if parse(url).scheme != "sim":
            return self._open_port(url)  # `replay:` starts over each time
        from mikas.link.virtual import RealTimeVirtualLink  # a car does not need it

        if (car := self._cars.get(url)) is not None:
            return RealTimeVirtualLink(car, url=url)
        link = self._open_port(url)
        if isinstance(link, RealTimeVirtualLink):
            self._cars[url] = link.bus
        return link
