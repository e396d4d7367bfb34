"""One recording as the rows of the dataset: a function of its bytes and of the settings alone.

Values, gaps and derived channels are those of an export (`recording/`), warm idle, statistics and
alarms those of a report (`report/measurements/`). A *drive* is one session of one port of a file:
most recordings have one.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from hashlib import sha256
from math import isfinite
from pathlib import Path
from typing import TypeAlias, TypeVar

from mikas.catalog import Catalog
from mikas.cleaning import clean_line
from mikas.commands.unit import version_text
from mikas.drives.collecting import TripCollector
from mikas.errors import CaptureError
from mikas.fleet.cars import CarKey, car_key, partition
from mikas.fleet.causes import CauseCollector
from mikas.fleet.states import DriveState, StateCollector
from mikas.fleet.tables import EDITION
from mikas.fleet.writing import TableWriter, timestamp
from mikas.i18n import Text
from mikas.recording.annotations.cars import SeveralCars
from mikas.recording.annotations.events import RecordedUnit, car_of, recorded_faults, unit_of
from mikas.recording.capture.notes import Note
from mikas.recording.capture.reader import Source
from mikas.recording.export.sheet import program
from mikas.recording.recorded_faults import FaultReadings
from mikas.recording.recording import Recording
from mikas.recording.splitting import split
from mikas.recording.table.channels import Rows, with_gaps
from mikas.report.measurements.measurements import MeasurementCollector, Measurements
from mikas.report.measurements.statistics import ChannelStatistics
from mikas.sampling.events import Event, Gap

_Numbered = TypeVar("_Numbered", Note, Event)
NOTHING = Text(
    "it is a recording, but nothing of a car is in it: no response and no fault reading",
    "это запись, но о машине в ней ничего нет: ни ответов блока, ни считанных ошибок",
)
_GIVEN = Text(
    "it holds recordings of several cars, and --car names one; make a file of each with "
    "`mikas split`",
    "в файле записи нескольких машин, а --car называет одну; сделайте по файлу на каждую: "
    "`mikas split`",
)


@dataclass(frozen=True, slots=True)
class InterpretingSettings:
    """What decides, besides the bytes, on the rows. `car`: given for all; empty: it is not."""

    catalog: Catalog
    interpretation: str = "corrected"
    car: str = ""

    @property
    def version(self) -> str:
        """The version of what interprets: another one interprets a recording again."""
        catalog = self.catalog.version
        return f"{program()}, tables {EDITION}, catalog {catalog}, {self.interpretation}"


@dataclass(frozen=True, slots=True)
class Interpreted:
    """The files of a recording by name in the dataset, and its figures. `cars`: several cars'
    names, empty for an unknown one; else `car` is the one.
    """

    files: dict[str, Path]
    car: str | None
    drives: int
    rows: int
    seconds: float
    damaged: int
    cars: tuple[str, ...] = ()


@dataclass(slots=True)
class _Drive:
    """One port of one session, as its rows are read."""

    number: int
    source: Source
    measuring: MeasurementCollector
    states: StateCollector
    causes: CauseCollector = field(default_factory=CauseCollector)
    trips: TripCollector = field(default_factory=TripCollector)
    began: float | None = None
    ended: float | None = None
    gaps: list[Gap] = field(default_factory=list)

    def add(self, rows: Rows, corrected: Rows) -> None:
        self.measuring.add(corrected)
        self.states.add(corrected)
        self.causes.add(corrected)
        self.trips.add(corrected)
        first, last = float(rows.times.min()), float(rows.times.max())
        self.began = first if self.began is None else min(self.began, first)
        self.ended = last if self.ended is None else max(self.ended, last)


def interpret(
    path: Path, name: str, key: str, settings: InterpretingSettings, folder: Path
) -> Interpreted:
    """Write the tables of a recording into `folder`. `name`: of its file; `key`: of its content.

    The drives of each car in it go to that car. Raises `CaptureError` for a file without a
    recording, `OSError` for a full disk.
    """
    with suppress(SeveralCars):
        return _of_one_car(path, name, key, settings, folder)
    if settings.car:
        raise CaptureError(name, _GIVEN)
    made: list[Interpreted] = []
    for number, (_, part) in enumerate(split(path, folder / "car.pcapng")):
        place = folder / str(number)
        place.mkdir()
        first = sum(each.drives for each in made)
        with suppress(_NothingOfCar):
            made.append(_of_one_car(part, name, key, settings, place, first=first))
        part.unlink()
    if not made:
        raise CaptureError(name, NOTHING)
    return Interpreted(
        {file: place for each in made for file, place in each.files.items()},
        None, sum(each.drives for each in made), sum(each.rows for each in made),
        sum(each.seconds for each in made), sum(each.damaged for each in made),
        tuple(each.car or "" for each in made),
    )  # fmt: skip


class _NothingOfCar(CaptureError):
    """A recording without a response and without a fault reading."""


def _of_one_car(
    path: Path,
    name: str,
    key: str,
    settings: InterpretingSettings,
    folder: Path,
    *,
    first: int = 0,
) -> Interpreted:
    """Write the tables of one car. `first`: the number of its first drive in the file."""
    recording = Recording(path, settings.catalog, settings.interpretation)
    reader = _Reader(recording, name, key, settings, first)
    with TableWriter(folder, recording.channels) as writer:
        for drive, rows in reader.rows():
            writer.add_samples(drive.number, rows, reader.zero or 0.0)
            reader.write_finished(writer)
        reader.add_without_rows()
        reader.write_finished(writer)
        if not reader.count:
            raise _NothingOfCar(name, NOTHING)
        ids = [_id(key, first + number) for number in range(reader.count)]
        facts = {"program": settings.version, "recording": key, "file": name}
        # Tables of their own for each car, and for a copy, which may be read at the same time.
        written = sha256(f"{settings.version}\n{name}\n{first}".encode())
        file_name = f"{key}-{written.hexdigest()[:8]}.parquet"
        files = {
            f"{table}/{partition(reader.car.name, day)}/{file_name}": file
            for table, day, file in writer.write(ids, facts)
        }
    return Interpreted(
        files, reader.car.name, len(ids), reader.row_count, reader.seconds, recording.problem_count
    )


def _id(key: str, number: int) -> str:
    return key if not number else f"{key}-{number + 1}"


class _Reader:
    """Reads the drives of a recording, one session after the other: a file may hold thousands.

    `zero`: the time of its first row; `count`: of the drives; `row_count`, `seconds`: of those that
    are written. Collected values are kept for the present session only.
    """

    def __init__(
        self,
        recording: Recording,
        name: str,
        key: str,
        settings: InterpretingSettings,
        first: int,
    ) -> None:
        self._recording, self._name, self._key, self._first = recording, name, key, first
        self._settings = settings
        self.count, self.row_count, self.seconds = 0, 0, 0.0
        self._finished: list[_Drive] = []
        self._open: dict[Source, _Drive] = {}
        self._seen: set[Source] = set()
        self.zero: float | None = None
        self._readings = FaultReadings(recording)
        self._catalog = settings.catalog
        self._corrected = recording
        if settings.interpretation != "corrected":
            self._corrected = recording.interpreted("corrected")
        self._details = car_of(recording.notes)
        self.car: CarKey = car_key(settings.car, self._details, recording.unit)
        self._notes = _by_recording(recording.notes)
        self._events = _by_recording(recording.events)

    def rows(self) -> Iterator[tuple[_Drive, Rows]]:
        """Yield the rows as an export has them, gaps too, each with its drive."""
        drive: _Drive | None = None
        former: _Drive | None = None

        def read() -> Iterator[Rows]:
            nonlocal drive
            both = (
                zip(self._recording.stretches(), self._corrected.stretches(), strict=True)
                if (self._corrected is not self._recording)
                else ((each, each) for each in self._recording.stretches())
            )
            for (source, rows), (_, corrected) in both:
                if len(rows.times):
                    drive = self._drive(source)
                    drive.add(rows, corrected)
                    yield rows

        for rows in with_gaps(read(), self._recording.events):
            if self.zero is None:
                self.zero = float(rows.times[0])
            assert drive is not None  # of the stretch that `with_gaps` has just read
            late = self._gaps_of(former, drive, rows)
            if former is not None and late:
                yield former, rows.part(slice(late))
            yield drive, rows.part(slice(late, None))
            former = drive
        self._finish()

    def _gaps_of(self, former: _Drive | None, drive: _Drive, rows: Rows) -> int:
        """Return how many of the first rows are gaps at the end of the session before."""
        if former is None or former.source.recording == drive.source.recording:
            return 0
        assert drive.began is not None  # it has rows
        gaps = (it.began for it in self._events[drive.source.recording] if isinstance(it, Gap))
        return int((rows.times < min((drive.began, *gaps))).cumprod().sum())

    def add_without_rows(self) -> None:
        """Add a drive for each session with readings of the faults and no rows."""
        ports = self._recording.raw.ports
        for source in sorted(ports, key=lambda each: (each.recording, each.url)):
            if source not in self._seen and self._readings.readings_of_port(source):
                self._drive(source)
        self._finish()

    def _finish(self) -> None:
        self._finished += self._open.values()
        self._open = {}

    def _drive(self, source: Source) -> _Drive:
        if source in self._open:
            return self._open[source]
        if any(it.recording != source.recording for it in self._open):
            self._finish()
        events = self._events[source.recording]
        known = self._catalog.channels
        names = [each.name for each in self._corrected.channels if each.name in known]
        measuring = MeasurementCollector(self._catalog, names, events)
        new = _Drive(self.count, source, measuring, StateCollector(self._catalog))
        if not self._open:  # the first port of the session
            new.gaps = [it for it in events if isinstance(it, Gap)]
        self.count += 1
        self._open[source] = new
        self._seen.add(source)
        return new

    def write_finished(self, writer: TableWriter) -> None:
        """Write the small rows of the drives that have ended, and drop what they collected."""
        while self._finished:
            drive = self._finished.pop(0)
            identity = _id(self._key, self._first + drive.number)
            for table, time, row in self._small_rows(drive):
                writer.add_row(table, time, {"drive": identity, **row})

    def _small_rows(self, drive: _Drive) -> Iterator[_Row]:
        """Yield (table, time, row) of a drive for the small tables."""
        measured = drive.measuring.measured
        self.row_count += measured.rows
        if drive.began is not None and drive.ended is not None:
            self.seconds += drive.ended - drive.began
        heard = self._readings.readings_of_port(drive.source)
        began = drive.began if drive.began is not None else heard[-1].time if heard else None
        mine = self._notes[drive.source.recording]
        unit = unit_of(mine, self._catalog)
        row = self._drive_row(drive, measured, began, unit)
        stored = heard[-1].codes if heard else ()
        causes = drive.causes.columns(stored)
        trips = drive.trips.columns(self._recording, drive.source.recording)
        yield "drives", began, {**row, **causes, **trips, "fault_readings": len(heard)}
        states: dict[tuple[str, DriveState], ChannelStatistics] = {
            **{(name, DriveState.ALL): stats for name, stats in measured.whole.items()},
            **{(name, DriveState.WARM_IDLE): stats for name, stats in measured.at_idle.items()},
            **drive.states.statistics(),
        }
        for (name, state), stats in states.items():
            yield "statistics", began, {
                "began": timestamp(began), "channel": name,
                "unit": self._catalog.channel(name).unit, "state": state.value,
                "count": stats.count, "mean": stats.mean, "median": stats.median,
                "low": stats.low, "high": stats.high, "least": stats.least, "most": stats.most,
            }  # fmt: skip
        before = len(list(recorded_faults(mine)))
        for number, reading in enumerate(heard):
            for code in dict.fromkeys(reading.codes) or (None,):
                fault = None if code is None else self._catalog.fault(code)
                yield "faults", reading.time, {
                    **self._at(reading.time), "reading": number, "code": code,
                    "en": fault.text.en if fault and fault.known else None,
                    "ru": fault.text.ru if fault and fault.known else None,
                    "message": fault.informational if fault else None,
                    "erased": reading.erased, "before": number < before,
                }  # fmt: skip
        for gap in drive.gaps:
            length = None if gap.ended is None else gap.ended - gap.began
            reason = gap.reason or Text("", "")
            yield "gaps", gap.began, {
                **self._at(gap.began), "seconds": length,
                "en": reason.en or None, "ru": reason.ru or None,
            }  # fmt: skip
        for alarm in measured.alarms:
            yield "alarms", alarm.began, {
                **self._at(alarm.began), "channel": alarm.limit.name,
                "level": alarm.limit.level.value, "side": alarm.limit.side.value,
                "bound": alarm.limit.value, "times": alarm.times, "seconds": alarm.seconds,
                "peak": alarm.peak if isfinite(alarm.peak) else None, "still": alarm.still,
                "by_event": alarm.by_event,
            }  # fmt: skip

    def _at(self, time: float) -> dict[str, object]:
        since = None if self.zero is None else time - self.zero
        return {"time": since, "utc": timestamp(time)}

    def _drive_row(
        self, drive: _Drive, measured: Measurements, began: float | None, unit: RecordedUnit | None
    ) -> dict[str, object]:
        car = self._details
        ended = drive.ended if drive.ended is not None else began
        passport = " · ".join(filter(None, (unit.passport if unit else None) or ()))
        return {
            "recording": self._key, "file": clean_line(self._name),
            "began": timestamp(began), "ended": timestamp(ended),
            "seconds": None if began is None or ended is None else ended - began,
            "rows": measured.rows,
            "known_by": self.car.known_by.value if self.car.known_by else None,
            "name": car.car or None, "plate": car.plate or None, "mileage": car.mileage,
            "workshop": car.workshop or None,
            "model": unit.model.en if unit and unit.model else None,
            "version_code": version_text(unit.version_code) if unit else None,
            "passport": passport or None, "virtual": drive.source.url.startswith("sim:"),
            "port": drive.source.url or None, "adapter": drive.source.description or None,
            "gaps": len(drive.gaps), "damaged_places": self._recording.problem_count,
            "warm_idle_seconds": measured.idle.seconds,
            "coolant_first": drive.states.coolant_first, "warm_up_seconds": drive.states.warm_up,
            "program": program(), "catalog": self._catalog.version,
            "interpretation": self._settings.interpretation,
        }  # fmt: skip


def _by_recording(items: Iterable[_Numbered]) -> dict[int, list[_Numbered]]:
    """Return notes or events by the session that they are of."""
    found: dict[int, list[_Numbered]] = defaultdict(list)
    for item in items:
        found[item.recording].append(item)
    return found


_Row: TypeAlias = tuple[str, float | None, dict[str, object]]
