"""A recording as a table, for exports and for notebooks (`mikas.notebook`).

Parameters are decoded from the raw bytes by the present catalog, derived channels computed from
them. numpy and the data frames' libraries are imported on use.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Literal, get_args

from mikas.catalog import Catalog
from mikas.cleaning import clean_line
from mikas.errors import usage_error
from mikas.i18n import Text
from mikas.options import check_choice
from mikas.recording.annotations.events import RecordedUnit, catalogs_of, events_of, first_unit
from mikas.recording.capture.notes import Note
from mikas.recording.capture.reader import Problem, Source
from mikas.recording.table.channels import (
    Channel,
    Rows,
    all_channels,
    calendar,
    is_recorded,
    known_but,
    named,
)
from mikas.sampling.events import Event, MethodChosen

if TYPE_CHECKING:
    import pandas as pd
    import polars as pl
    import pyarrow as pa

    from mikas.instruments import InstrumentDefinition
    from mikas.recording.table.dataframes import Table
    from mikas.recording.table.instrument_columns import InstrumentSamples
    from mikas.recording.table.raw_recording import RawRecording
    from mikas.recording.table.window import Windows

Clock = Literal["elapsed", "clock"]
"""The time of a table's rows: seconds from the first row, or the date and the time of day."""


class Recording:
    """One recording. `channels`: its columns, parameters first, then those derived from them,
    then those of instruments beside the unit.

    `instruments`: definitions, by name, file or themselves, that decode the instruments of these
    names, in place of the known ones.

    `absent`: the wanted channels without recorded values; their columns are empty.

    Opening reads the file once, a second for ten hours, and holds what it has, `raw`: 36 MB for ten
    hours. All else is made of that.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        catalog: Catalog,
        interpretation: str = "corrected",
        names: Iterable[str] = (),
        *,
        raw: RawRecording | None = None,
        last_car: bool = False,
        instruments: Iterable[str | InstrumentDefinition] = (),
    ) -> None:
        from mikas.recording.table.conversion import Converter
        from mikas.recording.table.instrument_columns import InstrumentColumns, given_definitions
        from mikas.recording.table.raw_recording import RawRecording

        names = (names,) if isinstance(names, str) else tuple(names)
        self._definitions = tuple(given_definitions(instruments, catalog).values())
        unknown = known_but(catalog, names)
        Converter(catalog, interpretation, ())  # raises, before the file is read
        self.raw: RawRecording = raw or RawRecording(path, catalog.size_of, last_car=last_car)
        """The bytes and exchanges of the file."""
        self.path: Path = self.raw.path
        """The file."""
        self.catalog = catalog
        """The definitions that decode it."""
        self.interpretation = interpretation
        """The interpretation of the source's errata."""
        self._converter = Converter(catalog, interpretation, self.raw.codes)
        recorded = {channel.name: channel for channel in self._converter.channels}
        self._instruments = InstrumentColumns(self.raw.instruments, catalog, self._definitions)
        beside = self._instruments.channels

        def meant(name: str) -> str:
            own = name.strip().upper()
            if own in beside or (name in unknown and own in catalog.instruments):
                return own
            return named(catalog, name)

        wanted = [meant(name) for name in names]
        known = all_channels(recorded, catalog, wanted, beside)
        self.channels: tuple[Channel, ...] = tuple(
            known[name] for name in dict.fromkeys(wanted or known)
        )
        """The columns, in their order."""
        self._derived = [each.name for each in self.channels if each.name in catalog.derived]
        self.absent: tuple[str, ...] = tuple(
            each.name
            for each in self.channels
            if not is_recorded(each.name, catalog, {**recorded, **beside})
        )
        """The wanted channels that the file lacks."""
        self._begins: dict[int, float] = {}  # of sessions, by number: the time of the first row

    @cached_property
    def about(self) -> dict[str, str]:
        """Facts of the file's first recording, by title; unknown ones are left out."""
        unit = self.unit or RecordedUnit()
        source = self.raw.source or Source(0)
        # The first plan precedes any measurement of methods.
        chosen = [event.method for event in self.events if isinstance(event, MethodChosen)]
        facts = {
            "recording": clean_line(self.path.name),
            "port": source.url,
            "adapter": source.description or unit.adapter,
            "computer": source.hardware,
            "recorded by": source.application,
            "unit": unit.model.en if unit.model else "",
            "passport": " · ".join(filter(None, unit.passport or ())),
            "method": (self.unit and ", ".join(dict.fromkeys(chosen))) or unit.method,
            "recorded with catalog": ", ".join(catalogs_of(self.notes)),
            "catalog": self.catalog.version,
            "reading": self.interpretation,
        }
        return {title: text for title, text in facts.items() if text}

    @cached_property
    def unit(self) -> RecordedUnit | None:
        """The unit of the file's first recording with a note of one; else None."""
        return first_unit(self.notes, self.catalog)

    @cached_property
    def events(self) -> tuple[Event, ...]:
        """The noted events: markers, gaps, states, alarms …, in the file's order."""
        return tuple(events_of(self.notes, self.catalog))

    def window(
        self, begin: float, end: float, points: int = 2000, names: Iterable[str] | None = None
    ) -> tuple[Rows, bool]:
        """Return the rows from `begin` to `end` of the link's clock, and if they are decimated.

        More than `points` rows are decimated (`table/decimation.py`) to about as many. `names`: of
        `channels`, all by default. The first call reads the whole recording into memory (seconds
        and about 130 MB for ten hours); the others are quick.
        """
        known = [each.name for each in self.channels]
        wanted = known if names is None else [self._named(name) for name in names]
        for name in wanted:
            if name not in known:
                raise usage_error(
                    f"{name} is not among this recording's channels",
                    f"{name} нет среди каналов этой записи",
                )
        return self._windows.window(begin, end, points, wanted)

    def _named(self, name: str) -> str:
        own = name.strip().upper()
        return own if own in self._instruments.channels else named(self.catalog, name)

    @cached_property
    def span(self) -> tuple[float, float] | None:
        """The times of the first and the last row; None without rows."""
        times = self._windows.times
        return (float(times[0]), float(times[-1])) if times.size else None

    def session_after(self, number: int, time: float) -> float | None:
        """Return the first row's time of the next session behind session `number` and `time`."""
        if self.span is None:  # else all rows have been read
            return None
        begins = (begin for session, begin in self._begins.items() if session > number)
        return min((begin for begin in begins if begin > time), default=None)

    @property
    def row_count(self) -> int:
        """The number of its rows."""
        return self.raw.row_counts.total()

    @property
    def held(self) -> int:
        """About as many bytes of memory as it takes now."""
        windows: Windows | None = self.__dict__.get("_windows")
        return self.raw.held + (windows.held if windows is not None else 0)

    @property
    def notes(self) -> list[Note]:
        """The notes of all its sessions."""
        return self.raw.notes

    @cached_property
    def _windows(self) -> Windows:
        from mikas.recording.table.window import Windows

        conversions = {
            each.name: each.interpretation(self.interpretation) for each in self.catalog.parameters
        }
        return Windows(self._noting_begins(), conversions)

    def _noting_begins(self) -> Iterator[Rows]:
        """Yield the rows, and note the begins of the sessions."""
        for source, rows in self.stretches():
            if len(rows.times):
                self._begins.setdefault(source.recording, float(rows.times[0]))
            yield rows

    @property
    def formula_catalog(self) -> Catalog:
        """The catalog with the channels of the file's instruments, for formulas of a person."""
        return self.catalog.with_beside(self._instruments.described)

    @property
    def instrument_channels(self) -> tuple[str, ...]:
        """The channels of all instruments of the file, also those that are no columns here."""
        return tuple(self._instruments.channels)

    def instrument_samples(self, name: str, session: int) -> InstrumentSamples | None:
        """Return what an instrument measured in a session, with its own times; None: nothing."""
        return self._instruments.samples(session, name)

    @property
    def instruments_unread(self) -> tuple[Text, ...]:
        """Why instruments of the file have no channels: their definitions can't be used."""
        return tuple(error.reason for _, error in self._instruments.unread)

    @property
    def problems(self) -> tuple[Problem, ...]:
        """The places of the file that could not be read, with offsets, up to a thousand."""
        return tuple(self.raw.problems)

    @property
    def problem_count(self) -> int:
        """The number of all such places."""
        return self.raw.problem_count

    def __repr__(self) -> str:
        names = " ".join(channel.name for channel in self.channels)
        return f"<Recording {str(self.path)!r}: {len(self.channels)} channels: {names}>"

    def rows(self) -> Iterator[Rows]:
        """Yield the recording in stretches.

        A row is a response, its time the response's begin on the link's clock (UNIX time of a real
        one); a missing value is NaN, flags are 0 and 1. Times rise within a stretch. They may run
        back between two stretches: another port, another session.
        """
        for _, rows in self.stretches():
            yield rows

    def stretches(self, session: int | None = None) -> Iterator[tuple[Source, Rows]]:
        """Yield the rows, each stretch with the port and the session that it comes from.

        Of one `session`, they come at best many at a time: where a clock runs to and fro, times run
        back within a stretch.
        """
        from mikas.recording.table.conversion import Converter
        from mikas.recording.table.derived import Deriver

        recorded = [each.name for each in self._converter.channels]
        wanted = {each.name for each in self.channels}
        names = recorded if self._derived else [name for name in recorded if name in wanted]
        converters = [self._converter]
        if self._derived and self.interpretation != "corrected":
            converters.append(Converter(self.catalog, "corrected", self.raw.codes))
        raw, rising = self.raw, session is None
        found = (
            each.stretches(raw.stretches(session), names, rising=rising) for each in converters
        )
        derivers: dict[Source, Deriver] = {}
        for stretch in zip(*found, strict=True):
            (source, rows), (_, corrected) = stretch[0], stretch[-1]
            derived, inputs = {}, set(self.catalog.required_beside(self._derived))
            beside = self._instruments.values(source.recording, rows.times, wanted | inputs)
            if self._derived:
                if source not in derivers:
                    derivers[source] = Deriver(self.catalog, self._derived)
                derived = derivers[source].columns(
                    corrected, {name: beside[name] for name in inputs if name in beside}
                )
            yield source, self._chosen(Rows(rows.times, {**rows.values, **derived, **beside}))

    def interpreted(
        self,
        interpretation: str,
        names: Iterable[str] = (),
        *,
        catalog: Catalog | None = None,
    ) -> Recording:
        """Return the same recording in an interpretation, with these channels, all by default.

        The file is not read again, unless `catalog` has data of other sizes.
        """
        catalog = catalog or self.catalog
        raw = self.raw if catalog.codes == self.catalog.codes else None
        several = len(self.raw.cars) > 1
        return Recording(
            self.path,
            catalog,
            interpretation,
            names,
            raw=raw,
            last_car=several,
            instruments=self._definitions,
        )

    def to_pandas(self, *, time: Clock = "elapsed", zone: str = "UTC") -> pd.DataFrame:
        """Return a `pandas.DataFrame`; its index is `time`, units are in `attrs`.

        `time`: elapsed, seconds from the first row, or clock, the date and the time of day in
        `zone`, such as Europe/Moscow. Raises `UsageError` for the clock of a recording without a
        date, `MissingExtra` without pandas; so do the other two.
        """
        from mikas.recording.table.dataframes import pandas_frame

        return pandas_frame(self._table("pandas", time, zone))

    def to_polars(self, *, time: Clock = "elapsed", zone: str = "UTC") -> pl.DataFrame:
        """Return a `polars.DataFrame` with a column `time`, as of `to_pandas`; missing is null."""
        from mikas.recording.table.dataframes import polars_frame

        return polars_frame(self._table("polars", time, zone))

    def to_arrow(self, *, time: Clock = "elapsed", zone: str = "UTC") -> pa.Table:
        """Return a `pyarrow.Table` with a column `time`, as of `to_pandas`.

        Units and texts are in the metadata of its fields.
        """
        from mikas.recording.table.dataframes import arrow_table

        return arrow_table(self._table("pyarrow", time, zone))

    def _chosen(self, rows: Rows) -> Rows:
        import numpy as np

        missing = np.full(len(rows.times), np.nan)
        values = {each.name: rows.values.get(each.name, missing) for each in self.channels}
        return Rows(rows.times, values)

    def _table(self, name: str, time: Clock, zone: str) -> Table:
        """Return the whole table for the library `name`, with its time as `to_pandas` says."""
        import numpy as np

        from mikas.recording.table.channels import joined_rows, with_gaps
        from mikas.recording.table.dataframes import Table, library
        from mikas.recording.table.dates import checked_zone, microseconds

        library(name)  # may be missing: before the file is read
        check_choice("time", time, get_args(Clock))
        if checked_zone(zone) != "UTC" and time != "clock":
            raise usage_error(
                f'the zone {zone} is of time="clock"; elapsed seconds have none',
                f'пояс {zone} нужен для time="clock"; у секунд от начала его нет',
            )
        none = self._chosen(Rows(np.empty(0), {}))
        rows = joined_rows([none, *with_gaps(self.rows(), self.events)])
        zero = float(rows.times[0]) if rows.times.size else 0.0
        started = calendar(zero)
        facts = {
            "started": started.isoformat() if started else None,
            "about": dict(self.about),
            "units": {channel.name: channel.unit for channel in self.channels},
            "channels": {channel.name: channel.facts() for channel in self.channels},
        }
        moments = microseconds(rows.times) if time == "clock" else None
        return Table(self.channels, rows.times - zero, rows.values, facts, moments, zone)
