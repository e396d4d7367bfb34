"""The instruments of the running connection: kept over a restart, read beside the unit's line.

    instruments.json ──► chosen ──► SessionInstruments ── values, changes ──► the sampling thread
                                            └── bytes ──► the recorder, while it may write

They are read while the unit's port is open or looked for. What happens to one never reaches the
line: each has a thread of its own.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Final

from mikas.catalog import Catalog, InstrumentChannel
from mikas.client import Ecu
from mikas.dashboard.errors import NotConnected, NotFound
from mikas.dashboard.session.connection import Connection
from mikas.dashboard.session.instruments.own_definitions import OwnDefinitions
from mikas.dashboard.session.instruments.positions import (
    PHONE,
    POSITIONS,
    PositionSource,
    phone,
)
from mikas.dashboard.session.port_threads import SamplingThread
from mikas.dashboard.settings import Settings
from mikas.errors import MikasError, usage_error
from mikas.i18n import Text
from mikas.instruments import InstrumentDefinition
from mikas.instruments.choosing import (
    ChosenInstrument,
    check_beside,
    check_together,
    placed,
)
from mikas.instruments.reading import InstrumentReader, InstrumentReading
from mikas.instruments.session_instruments import SessionInstruments
from mikas.recording.capture.instruments import CONNECTED, instrument_port, loss
from mikas.recording.recorder import Recorder
from mikas.sampling.beside import SamplesBeside
from mikas.sampling.events import AlarmChanged, Sampled
from mikas.sampling.instrument_changes import InstrumentChanged
from mikas.sampling.plan import Selection
from mikas.saving import KeptFile

_MOST_BYTES: Final = 1 << 16


@dataclass(eq=False)
class _Gate:
    """The recorder, until the instruments are replaced: others have the numbers then."""

    _recorder: Recorder
    is_open: bool = True

    def record_instrument(self, number: int, data: bytes, time: float, comment: str = "") -> None:
        if self.is_open:
            self._recorder.record_instrument(number, data, time, comment)


class InstrumentsBeside:
    """The instruments that the user has chosen. `changed`: called with the names of the channels.

    `settings`: those in use. Requests are awaited in the event loop; the sampling thread calls
    `follow` and `with_values`.
    """

    def __init__(
        self,
        settings: Callable[[], Settings],
        connection: Connection,
        recorder: Recorder,
        changed: Callable[[tuple[str, ...]], object],
    ) -> None:
        self._settings, self._connection = settings, connection
        self._recorder, self._changed = recorder, changed
        state = settings().in_state("instruments.json")
        self.file: KeptFile[list[dict[str, str]]] = KeptFile(state, _MOST_BYTES, _entries)
        """The choice, as kept."""
        self.own: OwnDefinitions = OwnDefinitions(settings().in_state("instruments"))
        """The user's own definitions."""
        self.chosen: tuple[ChosenInstrument, ...] = ()
        self.problems: list[Text] = []
        """Why kept instruments are not read."""
        self.version: int = 0
        """Counts the changes of the choice and of the definitions."""
        self.changing: asyncio.Lock = asyncio.Lock()
        """Held while a request changes the choice or a definition."""
        self._positions: PositionSource | None = None
        self._beside: SessionInstruments | None = None
        self._samples = SamplesBeside(())
        self._selection: Callable[[], Selection] | None = None
        self._gate = _Gate(recorder)
        self._lock = threading.Lock()  # of `_beside` and what belongs to it

    @property
    def catalog(self) -> Catalog:
        """The catalog in use."""
        return self._settings().connection.catalog

    @property
    def channels(self) -> tuple[InstrumentChannel, ...]:
        """The channels of all instruments."""
        return tuple(channel for each in self.chosen for channel in each.channels)

    def ports(self) -> frozenset[str]:
        """Return the ports that are no unit's."""
        return frozenset(each.url for each in self.chosen)

    def definition(self, name: str) -> InstrumentDefinition:
        """Return a definition. Raises `UsageError`, `CatalogError`."""
        return phone(self.catalog) if name == PHONE else self.own.named(name, self.catalog)

    def placed(self, name: str, url: str, label: str) -> ChosenInstrument:
        """Return an instrument at a port. Raises `UsageError`, `BadPortUrl`, `CatalogError`."""
        definition = self.definition(name)
        if (name == PHONE) != (url == POSITIONS):
            raise usage_error(
                "The position of a phone has no port: position:",
                "У местоположения телефона нет порта: position:",
            )
        if url == POSITIONS:
            return ChosenInstrument(definition, url, label)
        found = placed(definition, url, label, self.catalog)
        if (port := self._connection.port) is not None:
            check_beside(port.url, [found])
        return found

    # The choice

    def load(self) -> None:
        """Use the kept choice; called at the start. What can't be used is left out, and said."""
        found: list[ChosenInstrument] = []
        problems: list[Text] = []
        for entry in self.file.load() or []:
            try:
                one = self.placed(entry["definition"], entry["port"], entry["label"])
                check_together([*found, one], self.catalog)
                found.append(one)
            except MikasError as error:
                problems.append(error.text)
        self.problems = problems
        self._use(tuple(found))

    async def add(self, one: ChosenInstrument) -> None:
        """Read one more. Raises `UsageError`."""
        async with self.changing:
            chosen = (*self.chosen, one)
            check_together(chosen, self.catalog)
            await self._replace(chosen)

    async def remove(self, title: str) -> None:
        """Read that one no more. Raises `NotFound`."""
        async with self.changing:
            left = tuple(each for each in self.chosen if each.title != title)
            if len(left) == len(self.chosen):
                raise NotFound(name=title)
            await self._replace(left)

    async def redefine(self, name: str) -> None:
        """Use the changed definition of that name, where it is chosen; `changing` is held."""
        chosen = tuple(
            replace(each, definition=self.definition(name))
            if each.definition.name == name
            else each
            for each in self.chosen
        )
        check_together(chosen, self.catalog)
        await self._replace(chosen)

    def use_catalog(self) -> list[AlarmChanged]:
        """Use another catalog for texts and limits, without a pause in the instruments' values.

        Returns the ends of the alarms whose limits are others now.
        """
        chosen = []
        for each in self.chosen:
            try:
                definition = self.definition(each.definition.name)
            except MikasError:  # its file is wrong by now, which is said where it is listed
                definition = each.definition
            chosen.append(replace(each, definition=definition))
        self.chosen = tuple(chosen)
        self.version += 1
        return self._samples.use_instruments(self.channels, self._connection.now())

    async def _replace(self, chosen: tuple[ChosenInstrument, ...]) -> None:
        """Keep the choice and read those from now on; a recording goes on in another file."""
        await asyncio.to_thread(self.file.save, [_entry(each) for each in chosen])
        await asyncio.to_thread(self.end)

        def between_cycles(ecu: Ecu) -> None:
            ecu.forget_list()
            self._use(chosen)

        try:
            if self._recorder.status is None:
                self._use(chosen)
            else:
                try:
                    await self._connection.ask(between_cycles)
                except NotConnected:  # no stream runs that would have to be restarted
                    self._use(chosen)
        finally:
            thread = self._connection.thread
            if thread is not None and not thread.ended:
                self.begin(thread)

    def _use(self, chosen: tuple[ChosenInstrument, ...]) -> None:
        self.chosen = chosen
        self.version += 1
        self._samples = SamplesBeside(self.channels)
        ports = [instrument_port(each.definition, each.url, each.label) for each in chosen]
        self._recorder.use_instruments(ports)
        self._changed(tuple(channel.name for channel in self.channels))

    # The running connection

    def begin(self, thread: SamplingThread) -> None:
        """Read the instruments beside the unit of this thread; those of another one end."""
        self.end()
        with self._lock:
            if not self.chosen:
                return
            self._gate = _Gate(self._recorder)
            self._positions = PositionSource(thread.port.now)
            self._selection = lambda: thread.acquisition.selection
            self._beside = SessionInstruments(
                self.chosen,
                thread.port,
                self._gate,
                (CONNECTED, loss),
                open_port=lambda url: self._settings().open_port(url),
                find=lambda: self._settings().find(),
                own_source=lambda each: self._positions if each.url == POSITIONS else None,
            )

    def end(self) -> None:
        """Close the instruments' ports; may take seconds. A second call does nothing."""
        with self._lock:
            beside, self._beside, self._positions = self._beside, None, None
            self._gate.is_open = False
        if beside is not None:
            beside.close()

    def follow(self) -> list[InstrumentChanged]:
        """Return the changes since the last call; in the sampling thread."""
        beside = self._beside
        return [InstrumentChanged.of(it) for it in beside.follow()] if beside else []

    def with_values(self, event: Sampled) -> Sampled:
        """Return the sample with the values of the instruments that are not too old.

        Also with the derived channels that need them.
        """
        beside, selection = self._beside, self._selection
        if beside is None or selection is None:
            return event
        return self._samples.completed(event, beside.fresh(event.time), selection())

    def alarms_of(self, event: Sampled) -> list[AlarmChanged]:
        """Return the changes of alarms by a sample; in the sampling thread."""
        return self._samples.alarms(event)

    def fresh(self) -> dict[str, InstrumentReading]:
        """Return the values that are not too old now, by channel."""
        beside = self._beside
        return dict(beside.fresh(self._connection.now())) if beside else {}

    def readers(self) -> dict[str, InstrumentReader]:
        """Return the readers by their titles; none while nothing is read."""
        beside = self._beside
        return {it.chosen.title: it for it in beside.readers} if beside else {}

    def put_position(self, keys: dict[str, float]) -> None:
        """Take a phone's position. Raises `NotFound`: no such instrument is chosen."""
        if not any(each.url == POSITIONS for each in self.chosen):
            raise NotFound(name=PHONE)
        if (positions := self._positions) is not None:
            positions.put(keys)


def _entry(each: ChosenInstrument) -> dict[str, str]:
    return {"definition": each.definition.name, "port": each.url, "label": each.label}


def _entries(stored: Any) -> list[dict[str, str]]:  # noqa: ANN401  (JSON of a file)
    """Return the kept choice. Raises `ValueError`, `TypeError`."""
    if not isinstance(stored, list):
        raise TypeError(type(stored))
    found = []
    for entry in stored:
        kept = {key: entry[key] for key in ("definition", "port", "label") if key in entry}
        if len(kept) < 3 or not all(isinstance(it, str) for it in kept.values()):
            raise ValueError(entry)
        found.append(kept)
    return found
