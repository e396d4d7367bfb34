"""What each reader makes of a file, in one form; and what `decode` says that it has to be.

`decode` goes frame by frame; all others must come to what it comes to. The expected rows are those
of the tests' reference.
"""

from __future__ import annotations

import csv
import importlib
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from math import isnan
from pathlib import Path
from typing import Any, Final

import mikas
from fuzz.exchanges.cases import Place
from fuzz.exchanges.lines import PORTS
from fuzz.exchanges.sessions import CATALOG
from mikas.errors import CaptureError
from mikas.fleet.interpreting import InterpretingSettings, interpret
from mikas.link.base import Direction
from mikas.recording.capture.notes import Note
from mikas.recording.capture.reader import CaptureReader, Packet, Problem, Source
from mikas.recording.exchanges.columns.matcher import column_exchanges
from mikas.recording.exchanges.result import Exchanges
from mikas.recording.exchanges.scalar import DecodedDamage, DecodedFrame
from mikas.recording.exchanges.turns import quick_exchanges
from mikas.recording.export import DIALECTS, export
from mikas.recording.inspect import Describer, Item, decode
from mikas.recording.splitting import cars_in, split

_TESTS: Final = Path(__file__).parents[2] / "tests"
_NAMES: Final = frozenset(p.name for p in CATALOG.parameters)
Row = tuple[tuple[str, float], ...]
"""The names and values of a row that are there, sorted."""


class Disagreement(Exception):
    """Two readers do not agree, or a value was invented. `name`: what is wrong, for counting."""

    def __init__(self, name: str, details: str) -> None:
        super().__init__(f"{name}: {details}")
        self.name = name


def harness(folder: str, module: str) -> Any:  # noqa: ANN401  (the tests carry no types)
    """Return a module of the tests: the same rule has one reference."""
    for path in (str(_TESTS), str(_TESTS / folder)):
        if path not in sys.path:
            sys.path.append(path)
    return importlib.import_module(module)


def place_of(source: Source) -> Place:
    port = PORTS.index(source.url)
    return max(0, source.recording - port), port  # a port of a section is a recording of its own


@dataclass(frozen=True, slots=True)
class Answer:
    """A received frame that is no echo. `codes`: of the list, for a 63; `meaning`: in words."""

    place: Place
    request: bytes | None
    codes: bytes | None
    body: bytes
    meaning: str


@dataclass(frozen=True, slots=True)
class Expected:
    """What `decode` makes of a file. `exchanges`: by port, as `_exchanges` gives them."""

    answers: tuple[Answer, ...]
    exchanges: dict[Place, Any]
    rows: tuple[tuple[Place, Row], ...]


def expected(path: Path) -> Expected:
    """Read the file frame by frame."""
    items = list(CaptureReader(path))
    parts = list(decode(items, lambda: Describer(CATALOG)))
    reference = harness("recording/exchanges", "exchanges_reference")
    answered = [
        it
        for it in parts
        if isinstance(it, DecodedFrame) and it.direction is Direction.RECEIVED and not it.echo
    ]
    answers = tuple(
        Answer(place_of(source), request, listed, body, part.meaning.en if part.meaning else "")
        for part, (source, _, body, request, listed, _) in zip(
            answered, reference.answers(items), strict=True
        )
    )
    rows = tuple(
        (place_of(source), _row(values)) for source, _, values in reference.rows(items, CATALOG)
    )
    return Expected(answers, _by_frames(parts), rows)


def _row(values: dict[str, float]) -> Row:
    return tuple(sorted((n, v) for n, v in values.items() if not isnan(v)))


def _by_frames(parts: list[Item]) -> dict[Place, Any]:
    found: dict[Place, Any] = {}
    for it in parts:
        if isinstance(it, Problem | Packet):
            continue
        requests, responses, counts = found.setdefault(place_of(it.source), ([], [], [0, 0]))
        if isinstance(it, DecodedDamage) and it.abandoned:
            continue
        if it.direction is Direction.SENT:
            requests.append(it.frame.body if isinstance(it, DecodedFrame) else None)
        elif it.echo:
            counts[0] += 1
        elif isinstance(it, DecodedFrame):
            responses.append((it.answers.serial, it.request, it.frame.body))
        else:
            counts[1] += 1
    return found


def _by_arrays(items: Iterator[Exchanges | Problem | Note]) -> dict[Place, Any]:
    """Return by port: the requests, the responses with their requests, and counts of echoes and
    damage.
    """
    found: dict[Place, Any] = {}
    for it in items:
        if not isinstance(it, Exchanges):
            continue
        requests, responses, counts = found.setdefault(place_of(it.source), ([], [], [0, 0]))
        bodies = [*it.bodies, None]
        requests += [bodies[number] for number in it.requests.numbers.tolist()]
        serials, numbers = it.responses.requests.tolist(), it.responses.numbers.tolist()
        responses += [
            (serial, bodies[number], it.responses.body(row))
            for row, (serial, number) in enumerate(zip(serials, numbers, strict=True))
        ]
        counts[0] += it.echoes
        counts[1] += len(it.damaged)
    return found


def _same(name: str, found: object, wanted: object) -> None:
    if found != wanted:
        raise Disagreement(name, f"\n  {found}\n  decode: {wanted}")


def _columns(path: Path, wanted: Expected) -> None:
    _same("columns", _by_arrays(column_exchanges(path, CATALOG.size_of)), wanted.exchanges)


def _turns(path: Path, wanted: Expected) -> None:
    _same("turns", _by_arrays(quick_exchanges(path, CATALOG.size_of)), wanted.exchanges)


@contextmanager
def _files_of_cars(path: Path) -> Iterator[list[Path]]:
    """Give a file of each car: units that say nothing of themselves, on two ports, are two."""
    with tempfile.TemporaryDirectory(prefix="mikas-fuzz-") as folder:
        several = len(cars_in(path)) > 1
        yield [it for _, it in split(path, Path(folder) / "car.pcapng")] if several else [path]


def _table(path: Path, wanted: Expected) -> None:
    with _files_of_cars(path) as files:
        rows = [
            (
                place_of(source),
                _row({n: float(v[at]) for n, v in rows.values.items() if n in _NAMES}),
            )
            for file in files
            for source, rows in mikas.open(file).stretches()
            for at in range(len(rows.times))
        ]
    _same("table", _by_place(rows), _by_place(wanted.rows))


def _by_place(rows: list[tuple[Place, Row]] | tuple[tuple[Place, Row], ...]) -> object:
    """Return the rows of each port: those of two may be in another order."""
    return {place: [row for it, row in rows if it == place] for place, _ in rows}


def _csv(path: Path, wanted: Expected) -> None:
    with _files_of_cars(path) as files:
        rows = [row for file in files for row in _exported(file)]
    _same("csv", sorted(rows), sorted(row for _, row in wanted.rows if row))


def _exported(path: Path) -> Iterator[Row]:
    recording = mikas.open(path)
    if not recording.channels:  # refused by the export
        return
    with tempfile.TemporaryDirectory(prefix="mikas-fuzz-") as folder:
        out = Path(folder) / "out.csv"
        export(
            out,
            recording.channels,
            recording.rows(),
            events=recording.events,
            about=recording.about,
            language="en",
            dialect=DIALECTS["plain"],
        )
        with out.open(encoding="utf-8", newline="") as file:
            titles, *lines = csv.reader(file)
    names = [title.partition(" ")[0] for title in titles]
    for line in lines:
        cells = zip(names, line, strict=True)
        if row := _row({n: float(cell) for n, cell in cells if n in _NAMES and cell}):
            yield row


def _fleet(path: Path, wanted: Expected) -> None:
    import duckdb

    with tempfile.TemporaryDirectory(prefix="mikas-fuzz-") as folder:
        settings = InterpretingSettings(CATALOG)
        try:
            made = interpret(path, path.name, "0" * 32, settings, Path(folder)).files
        except CaptureError:  # nothing of a car is in it
            made = {}
        rows: list[Row] = []
        for name, file in made.items():
            if name.startswith("samples/"):
                table = duckdb.read_parquet(str(file))
                for line in table.fetchall():
                    named = zip(table.columns, line, strict=True)
                    values = {n: float(v) for n, v in named if n in _NAMES and v is not None}
                    rows.append(_row(values))
    _same("fleet", sorted(rows), sorted(row for _, row in wanted.rows))


@dataclass(frozen=True, slots=True)
class Reader:
    """`compare` raises `Disagreement`; for every `each`-th case."""

    name: str
    compare: Callable[[Path, Expected], None]
    each: int = 1


READERS: Final = (
    Reader("columns", _columns),
    Reader("turns", _turns),
    Reader("table", _table),
    Reader("csv", _csv, each=4),
    Reader("fleet", _fleet, each=12),
)
