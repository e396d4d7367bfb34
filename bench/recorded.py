"""A long recording as `mikas log` writes it, made in seconds: what the benchmarks of reading read.

A session with a virtual unit on the simulated clock, by list, through `Coalescer` and
`CaptureWriter`; its steady part is repeated at shifted times until the file is as long as wanted.
A marker stands at the end of every lap, a gap of ten seconds at the end of every hour.

    python -m bench.recorded drive.pcapng --hours 10
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

import mikas
from mikas.client.parameters.polling import FixedMethod
from mikas.i18n import Text
from mikas.link.base import Direction
from mikas.recording import CaptureWriter, Coalescer
from mikas.recording.annotations.events import catalog_note, note_of
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.notes import Kind, Note, block_of
from mikas.sampling.alarms import Alarms
from mikas.sampling.events import Gap, LineState, Marker, StateChanged, TextNote, UnitFound

PORT = "sim:?clock=simulated&scenario=city"
START = 1_760_000_000  # UNIX time of the begin
_GAP = 10.0  # s, once an hour
_REASON = Text("echo, but the ECU is silent: ignition off?", "эхо есть, блок молчит")


def recorded(
    path: Path,
    hours: float = 10.0,
    *,
    lap: float = 300.0,
    method: FixedMethod = "list",
    start: float = START,
) -> Path:
    """Writes the recording; returns its path. `lap`: seconds of driving that are repeated;
    `start`: UNIX time of its begin.
    """
    lap = min(lap, hours * 3600)
    head, blocks = _session(path, lap, method, start)
    data = b"".join(map(pcapng.encode, blocks))
    edges = np.cumsum([0, *(len(pcapng.encode(block)) for block in blocks)])
    low = edges[:-1] // 4 + 4  # the word with the lower half of a block's ticks
    ticks = np.array([block.ticks for block in blocks])
    period = ticks[-1] - ticks[0] + 20_000
    words = np.frombuffer(data, "<u4").copy()
    shift = hour = 0
    with path.open("wb") as file:
        file.write(head)
        while shift < hours * 3.6e9:
            words[low - 1], words[low] = np.divmod(ticks + shift, 1 << 32)
            file.write(words.tobytes())
            shift += int(period)
            now = (int(ticks[0]) + shift) / 1e6
            file.write(_block(note_of(Marker(now, f"lap {shift // int(period)}"))))
            if shift // 3_600_000_000 > hour:
                hour = shift // 3_600_000_000
                file.write(_block(note_of(StateChanged(now, LineState.ECHO_ONLY, reason=_REASON))))
                file.write(_block(note_of(Gap(now, now, now + _GAP, _REASON))))
                file.write(_block(note_of(StateChanged(now + _GAP, LineState.SAMPLING))))
                shift += round(_GAP * 1e6)
        file.write(_block(note_of(TextNote(now, "the end of a long way"))))
    return path


def _session(
    path: Path, seconds: float, method: FixedMethod, start: float
) -> tuple[bytes, list[pcapng.EnhancedPacket]]:
    """The head of the file, and the packets of the steady part of the session."""
    alarms: list[Note] = []
    with (
        _Shifted(path, start) as writer,
        mikas.connect(PORT, sink=(sink := Coalescer(writer))) as ecu,
    ):
        passport = ecu.passport()
        ecu.faults()
        unit = UnitFound(
            ecu.tester.link.now(),
            ecu.version_code,
            passport,
            adapter=ecu.tester.link.description,
            echo=ecu.tester.line.echo,
        )
        sink.note(note_of(unit))
        sink.note(catalog_note(unit.time, ecu.catalog.version))
        watching = Alarms(ecu.catalog)
        end = ecu.tester.link.now() + seconds
        steady = None
        for sample in ecu.watch(method=method):
            sink.flush()
            steady = path.stat().st_size if steady is None else steady
            events = watching.update(sample.readings, sample.time)
            alarms += [note_of(event) for event in events]
            if sample.time >= end:
                break
        sink.flush()
        stop = path.stat().st_size
    data = path.read_bytes()
    assert steady is not None
    notes = b"".join(_block(Note(Kind.ALARM, note.time + start, note.data)) for note in alarms[:20])
    return data[:steady] + notes, _packets(data[steady:stop], method)


class _Shifted(CaptureWriter):
    """Everything as if the simulated clock had started at `start`."""

    def __init__(self, path: Path, start: float) -> None:
        super().__init__(path, url=PORT, overwrite=True)
        self._start = start

    def record(self, direction: Direction, data: bytes, time: float) -> None:
        super().record(direction, data, time + self._start)

    def note(self, note: Note) -> None:
        super().note(Note(note.kind, note.time + self._start, note.data))


def _packets(data: bytes, method: FixedMethod) -> list[pcapng.EnhancedPacket]:
    blocks = []
    at = 0
    while at < len(data):
        length = int.from_bytes(data[at + 4 : at + 8], "little")
        kind = int.from_bytes(data[at : at + 4], "little")
        block = pcapng.parse(kind, data[at + 8 : at + length - 4], "<")
        if isinstance(block, pcapng.EnhancedPacket):
            blocks.append(block)
        at += length
    # It begins with a request and ends before one, so that laps fit together; a stream has none
    # until it is ended.
    asks = [n for n, b in enumerate(blocks) if b.flags == pcapng.OUTBOUND]
    if method == "stream":
        return blocks[: asks[0]] if asks else blocks
    return blocks[asks[0] : asks[-1]]


def _block(note: Note) -> bytes:
    return pcapng.encode(block_of(note))


def main() -> None:
    arguments = argparse.ArgumentParser(description="Write a long recording.")
    arguments.add_argument("path", type=Path)
    arguments.add_argument("--hours", type=float, default=10.0)
    arguments.add_argument(
        "--method", default="list", choices=["single", "batch", "list", "stream"]
    )
    given = arguments.parse_args()
    made = recorded(given.path, given.hours, method=given.method)
    print(f"{made}: {made.stat().st_size / 1e6:.0f} MB")


if __name__ == "__main__":
    main()
