"""Everything that reads a recording, as a stranger's file meets it.

A reader raises what mikas raises for a person (`MikasError`), or returns. Anything else is a
finding, and so is a result that its taker can't use: JSON that is none, text with control
characters, an answer 500.
"""

from __future__ import annotations

import io
import json
import tempfile
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final
from xml.etree import ElementTree as ET

import mikas
from fuzz.recordings import dashboard
from fuzz.recordings.cases import Cases
from fuzz.recordings.limits import Allowance, Work, counted
from mikas.catalog import shipped
from mikas.cleaning import terminal_text
from mikas.cli.failures import BUG
from mikas.cli.main import run
from mikas.errors import MikasError, UsageError
from mikas.fleet.interpreting import InterpretingSettings, interpret
from mikas.i18n import Language
from mikas.notebook.panes import chosen_panes, coloured
from mikas.notebook.picture import picture_of
from mikas.recording.annotations.events import comment_note
from mikas.recording.capture.reader import CaptureReader, Problem
from mikas.recording.capture.writer import append_note
from mikas.recording.export import DIALECTS, export
from mikas.recording.inspect import Describer, decode, to_json
from mikas.recording.recorded_faults import faults_in
from mikas.recording.search import SearchCondition, search
from mikas.recording.summary import summarise
from mikas.replay.port import playing
from mikas.report.from_recording import find_in_recording
from mikas.report.page import render


@dataclass(frozen=True, slots=True)
class Reader:
    """`read` takes the file's path, of every `each`-th case."""

    name: str
    read: Callable[[Path], object]
    allowed: Allowance
    each: int = 1


class NotUsable(Exception):
    """A reader's result can't be used."""


def strict_json(text: str | bytes) -> Any:  # noqa: ANN401  (any JSON)
    """Return the JSON of `text`, which must be such as a browser reads. Raises `NotUsable`."""

    def refuse(word: str) -> None:
        raise NotUsable(f"{word} in JSON")

    return json.loads(text, parse_constant=refuse)


def _listed(path: Path) -> None:
    summarise(path)


def _decoded(path: Path) -> None:
    for item in decode(CaptureReader(path), lambda: Describer(shipped())):
        json.dumps(to_json(item), allow_nan=False, ensure_ascii=False).encode()


def _in_a_fleet(path: Path) -> None:
    with tempfile.TemporaryDirectory(prefix="mikas-fuzz-") as folder:
        interpret(path, path.name, "0" * 32, InterpretingSettings(shipped()), Path(folder))


def _on_terminal(path: Path) -> None:
    """All that `mikas decode` and a refusal print, in both languages, to a terminal."""
    for language in ("en", "ru"):
        out, err = io.StringIO(), io.StringIO()
        with redirect_stdout(out), redirect_stderr(err):
            status = run(["decode", str(path), "--lang", language])
        if status == BUG:
            raise NotUsable(err.getvalue())
        for text in (out.getvalue(), err.getvalue()):
            text.encode()
            for line in text.splitlines():
                if line != terminal_text(line).replace("\\x09", "\t"):
                    raise NotUsable(f"control characters: {line[:200]!r}")


def _as_table(path: Path) -> None:
    recording = mikas.open(path)
    for rows in recording.rows():
        len(rows.times)
    json.dumps(recording.about, ensure_ascii=False).encode()
    for event in recording.events:
        json.dumps(event.as_json(), allow_nan=False, ensure_ascii=False).encode()
    for problem in recording.problems:
        problem.text.ru.encode()


def _in_windows(path: Path) -> None:
    recording = mikas.open(path)
    begin, end = recording.span or (0.0, 1.0)
    middle = begin + (end - begin) / 2
    for first, last, points in (
        (begin, end, 2000),
        (begin, end, 20),
        (-1e300, 1e300, 2),
        (middle, end, 50),
        (end, begin, 50),
    ):
        rows, _ = recording.window(first, last, points)
        assert len(rows.times) <= max(points, 2 * points * (1 + len(rows.values)))


def _as_frames(path: Path) -> None:
    recording = mikas.open(path)
    recording.to_pandas()
    recording.to_polars()
    recording.to_arrow()


def _in_a_notebook(path: Path) -> None:
    """All that it shows of itself and draws, in both languages; HTML that is well-formed."""
    languages: tuple[Language, ...] = ("en", "ru")
    for language in languages:
        recording = mikas.open(path, language=language)
        ET.fromstring(recording._repr_html_())
        str(recording).encode()
    panes = coloured(chosen_panes(recording, (), group_by_unit=True))
    for stacked in (False, True):
        with suppress(UsageError):  # it has no values
            picture_of(recording, panes, language="ru", stacked=stacked, reference=True)


def _exported(suffix: str, dialect: str = "plain") -> Callable[[Path], None]:
    def write(path: Path) -> None:
        with tempfile.TemporaryDirectory(prefix="mikas-fuzz-") as folder:
            out = Path(folder) / f"out{suffix}"
            recording = mikas.open(path)
            export(
                out,
                recording.channels,
                recording.rows(),
                events=recording.events,
                about=recording.about,
                language="ru" if dialect == "excel" else "en",
                dialect=DIALECTS[dialect],
            )
            if suffix in (".csv", ".msl"):
                out.read_text("utf-8-sig" if dialect == "excel" else None)

    return write


def _reported(path: Path) -> None:
    found = find_in_recording(mikas.open(path))
    for page in (render(found, "en"), render(found, "ru")):
        page.encode()


def _with_faults(path: Path) -> None:
    faults_in(mikas.open(path))


def _replayed(path: Path) -> None:
    with mikas.connect(f"replay:{path}?clock=simulated", timeout=0.1, retries=0) as ecu:
        for ask in (ecu.passport, ecu.faults):
            with suppress(MikasError):
                ask()
        with suppress(MikasError):
            list(ecu.watch("TWAT", "FREQ", method="batch", count=3))
        car = playing(ecu.tester.link)
        if car is not None:
            car.seek(car.recorded.duration / 2, ecu.tester.link.now())
            with suppress(MikasError):
                ecu.read("TWAT")


def _commented(path: Path) -> None:
    """Add a comment, which must be in the file, and nothing else be changed."""
    before = path.read_bytes()
    problems = _problems(path)
    try:
        append_note(path, comment_note(1.0, "после ремонта"))
        after = path.read_bytes()
        if not problems and summarise(path).note != "после ремонта":
            raise NotUsable("the comment is not in the file")
        if not problems and not after.startswith(before):
            raise NotUsable("the comment has changed the recording")
    finally:
        path.write_bytes(before)


def _problems(path: Path) -> list[Problem]:
    return [item for item in CaptureReader(path) if isinstance(item, Problem)]


# Real recordings take up to 60,000 calls in any case, then up to 8 a byte, and read each byte up to
# 20 times (the dashboard, by ten requests, 70 times). Blocks of 12 bytes take more calls a byte.
_USUAL: Final = Allowance(calls=(400_000, 150), reads=(1 << 20, 100))
_SEVERAL: Final = Allowance(calls=(400_000, 500), reads=(1 << 20, 400))


def _searched(path: Path) -> None:
    for text in ("FREQ > 1000 and not RXX", "FUEL_FLOW < 3"):
        with suppress(UsageError):  # a channel that is not in the file
            search(mikas.open(path), SearchCondition(shipped(), text))


READERS: Final = (
    Reader("list", _listed, _USUAL),
    Reader("decode", _decoded, _USUAL),
    Reader("table", _as_table, _USUAL),
    Reader("report", _reported, _USUAL, each=2),
    Reader("faults", _with_faults, _USUAL, each=3),
    Reader("replay", _replayed, _USUAL, each=2),
    Reader("window", _in_windows, _USUAL, each=2),
    Reader("notebook", _in_a_notebook, _SEVERAL, each=4),
    Reader("csv", _exported(".csv"), _USUAL, each=2),
    Reader("msl", _exported(".msl"), _USUAL, each=3),
    Reader("mlg", _exported(".mlg"), _USUAL, each=3),
    Reader("search", _searched, _USUAL, each=5),
    Reader("comment", _commented, _USUAL, each=4),
    Reader("dashboard", dashboard.read, _SEVERAL, each=6),
    Reader("terminal", _on_terminal, _USUAL, each=5),
    Reader("excel", _exported(".csv", "excel"), _USUAL, each=6),
    Reader("frames", _as_frames, _USUAL, each=6),
    Reader("parquet", _exported(".parquet"), _USUAL, each=10),
    Reader("mf4", _exported(".mf4"), _USUAL, each=20),
    Reader("fleet", _in_a_fleet, _SEVERAL, each=4),
)


def readers_of(number: int) -> list[Reader]:
    """Return the readers of case `number`."""
    return [it for index, it in enumerate(READERS) if (number + index) % it.each == 0]


def read(reader: Reader, path: Path, *, calls: bool = True) -> Work:
    """Let one reader read the file; return its work. Raises all but a `MikasError`."""
    size = path.stat().st_size
    with counted(calls=calls) as work, suppress(MikasError):
        reader.read(path)
    work.check(size, reader.allowed)
    return work


def warm_up(path: Path, cases: Cases) -> None:
    """Import and cache everything, which is no reader's work."""
    for name in ("sections", "noted"):
        for reader in READERS:
            path.write_bytes(cases.real[name])
            reader.read(path)


def check(data: bytes) -> None:
    """Let every reader read `data`; print the work of each."""
    with tempfile.TemporaryDirectory(prefix="mikas-fuzz-") as folder:
        path = Path(folder) / "it.pcapng"
        warm_up(path, Cases(1))
        path.write_bytes(data)
        for reader in READERS:
            print(f"{reader.name}: {read(reader, path)}")
