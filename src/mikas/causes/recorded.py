"""The samples and stored faults of recordings, several of one car put together.

recordings ──► samples by session and port ──► rank ──► moments of the recordings
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from mikas.causes.knowledge import Complaint, Knowledge
from mikas.causes.ranking import rank
from mikas.causes.result import Evidence, Ranking
from mikas.causes.rows import CHANNELS, samples_of_rows, unserved
from mikas.causes.samples import Samples
from mikas.i18n import Text
from mikas.recording.annotations.cars import RecordedCar, SeveralCars
from mikas.recording.recorded_faults import FaultReadings
from mikas.sampling.events import FaultReading

if TYPE_CHECKING:
    from mikas.recording.capture.reader import Source
    from mikas.recording.recording import Recording
    from mikas.recording.table.channels import Rows


def samples_of_recording(recording: Recording) -> list[Samples]:
    """Return the samples of a recording, in the corrected interpretation: of each session and port
    its own, and of a clock that was set back others.
    """
    by_port: dict[Source, list[Rows]] = {}
    names = [name for name in CHANNELS if name in recording.catalog.channels]
    for source, rows in recording.interpreted("corrected", names).stretches():
        by_port.setdefault(source, []).append(rows)
    return [each for rows in by_port.values() for each in samples_of_rows(rows)]


def stored_faults(recordings: Iterable[Recording]) -> tuple[int, ...]:
    """Return the fault numbers of the latest reading of them all; none: not read."""
    latest: FaultReading | None = None
    for recording in recordings:
        readings, raw = FaultReadings(recording), recording.raw
        last = {p: rows for p, rows in raw.row_counts.items() if p.recording == raw.last_session}
        port = max(last, key=last.__getitem__, default=readings.port_without_rows())
        heard = readings.readings_of_port(port)
        if heard and (latest is None or heard[-1].time >= latest.time):
            latest = heard[-1]
    return tuple(latest.codes) if latest is not None else ()


def check_one_car(recordings: Sequence[Recording]) -> None:
    """Raise `SeveralCars` for recordings of different cars, or of different models of the unit.

    Unknown ones are believed. Of a file of several cars only the last one's is read.
    """
    known: RecordedCar | None = None
    first = ""
    for recording in recordings:
        for car in recording.raw.cars:
            if not car.is_known or not recording.raw.spans.keys() & set(car.recordings):
                continue
            if known is None:
                known, first = car, recording.path.name
                continue
            file = Text(first, first)
            if not known.is_same(car, {}):
                words = _OTHER_CAR.filled(mine=car.name, file=file, theirs=known.name)
                raise SeveralCars(str(recording.path), words)
            mine, theirs = _model_of(car), _model_of(known)
            if mine is not None and theirs is not None and mine != theirs:
                words = _OTHER_UNIT.filled(mine=mine, file=file, theirs=theirs)
                raise SeveralCars(str(recording.path), words)
            known = known.joined(car)


def _model_of(car: RecordedCar) -> Text | None:
    return car.unit.model if car.unit is not None else None


def rank_recordings(
    recordings: Sequence[Recording],
    *,
    complaint: Complaint | None = None,
    knowledge: Knowledge | None = None,
) -> Ranking:
    """Return the causes for the recordings of one car. Raises `SeveralCars`.

    The `source` of an evidence is the recording's number among `recordings`.
    """
    check_one_car(recordings)
    pieces = [
        (number, samples)
        for number, recording in enumerate(recordings)
        for samples in samples_of_recording(recording)
    ]
    samples = [each for _, each in pieces]
    ranking = rank(
        samples,
        complaint=complaint,
        faults=stored_faults(recordings),
        absent=unserved(samples),
        knowledge=knowledge,
    )
    return by_source(ranking, [number for number, _ in pieces])


def by_source(ranking: Ranking, numbers: Sequence[int]) -> Ranking:
    """Return the ranking with the numbers of recordings for those of samples."""
    causes = tuple(
        replace(
            cause,
            evidence_for=tuple(_renumbered(cause.evidence_for, numbers)),
            evidence_against=tuple(_renumbered(cause.evidence_against, numbers)),
        )
        for cause in ranking.causes
    )
    return replace(ranking, causes=causes)


def _renumbered(evidence: Iterable[Evidence], numbers: Sequence[int]) -> Iterator[Evidence]:
    for each in evidence:
        yield replace(each, source=numbers[each.source])


_OTHER_UNIT: Final = Text(
    "it is a recording of a {mine}, and {file} is one of a {theirs}; causes are ranked for one "
    "unit",
    "это запись блока {mine}, а {file} — блока {theirs}; причины ищут для одного блока",
)
_OTHER_CAR: Final = Text(
    "it is a recording of {mine}, and {file} is one of {theirs}; causes are ranked for one car",
    "это запись машины {mine}, а {file} — машины {theirs}; причины ищут для одной машины",
)
