"""What is checked of the hour: printed and recorded values, lost bytes, times, memory.

The guest's clock is not the host's; `GuestClock` compares them again and again. A value is right if
the unit gave it shortly before: `bench/soak_car.py` has data that tell code and moment.
"""

from __future__ import annotations

import json
import queue
import subprocess
import sys
import threading
from bisect import bisect_left
from collections import Counter
from dataclasses import dataclass, field
from functools import cache
from math import isnan
from pathlib import Path
from typing import Any

import numpy as np
from bench.soak_car import STEP, SoakCar

import mikas
from cable.guest_rig import Command
from mikas.catalog import shipped
from mikas.link import WallClock
from mikas.link.base import Direction
from mikas.recording.capture.reader import CaptureReader, Packet
from mikas.recording.summary import summarise
from usb.wire_rig import PATIENCE

AGE = 5.0  # s from the answer in the unit to its first byte in the guest, which can pause
AHEAD = 0.25  # s by which the two clocks may seem to differ
SAME = 0.02  # s by which a recorded time may differ from the printed one: chunks come late
CYCLE = 3.0  # s from the first to the last response of a printed set
ON_ITS_WAY = 62  # bytes of one USB packet, which are lost with the device
NOW = WallClock()


class GuestClock:
    """Turns times of the guest into times of the host."""

    def __init__(self) -> None:
        self._known: list[tuple[float, float, float]] = []  # guest's time, ahead, error
        self.error = 0.0
        """By how much a time may be wrong, in s."""

    def compare(self, before: float, guest: float, after: float) -> None:
        """Take the guest's time, asked for at `before` and received at `after`."""
        known = (guest, guest - (before + after) / 2, (after - before) / 2)
        # A busy guest answers late: only those that are about as good as the best one count.
        best = min(error for *_, error in (*self._known, known))
        self._known = [it for it in (*self._known, known) if it[2] <= 2 * best]
        self.error = max(error for *_, error in self._known)

    def host(self, guest: float) -> float:
        times, ahead, _ = zip(*self._known, strict=True)
        return guest - float(np.interp(guest, times, ahead))


class Given:
    """The values that the unit gave."""

    def __init__(self, car: SoakCar) -> None:
        self._car = car
        self._parameters = {each.name: each for each in shipped().parameters}
        self._at = cache(self._decode)
        self.oldest = 0.0
        """The longest time that a value was older than its response, in s."""

    def is_value(self, name: str, value: float, begin: float, end: float) -> bool:
        """Return whether the unit gave `value` between `begin` and `end`, or shortly before."""
        for step in range(int((end + AHEAD) // STEP), int((begin - AGE) // STEP) - 1, -1):
            if abs(self._at(name, step) - value) < 1e-6:
                self.oldest = max(self.oldest, begin - (step + 1) * STEP)
                return True
        return False

    def _decode(self, name: str, step: int) -> float:
        parameter = self._parameters[name]
        return float(parameter.conversion.decode(self._car.at(parameter.code, step)))


@dataclass
class Log:
    """A running `mikas log --json`, read in a thread of its own."""

    command: Command
    file: Path
    clock: GuestClock
    sets: list[tuple[float, dict[str, float]]] = field(default_factory=list)
    gaps: Counter[str] = field(default_factory=Counter)  # failed cycles by their reason
    memory: list[tuple[float, int]] = field(default_factory=list)  # host's time, KiB
    notes: str = ""
    status: int | None = None
    latest: float = 0.0  # time of the last set, by the guest's clock
    _asked: float = 0.0
    _changed: threading.Condition = field(default_factory=threading.Condition)

    def __post_init__(self) -> None:
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def ask_state(self) -> None:
        """Ask for time and memory, unless the answer to the last question is awaited."""
        if self.status is None and not self._asked:
            self._asked = NOW.now()
            self.command.order(state=True)

    def has_set_after(self, time: float, timeout: float) -> bool:
        """Wait for a set that began after the host's `time`; False at its end, or too late."""

        def has_come() -> bool:
            return self.status is not None or (
                self.latest > 0 and self.clock.host(self.latest) >= time
            )

        with self._changed:
            return self._changed.wait_for(has_come, timeout) and self.status is None

    def end(self, signal: int) -> None:
        """Send `signal`, and wait for the end."""
        self.command.order(signal=signal)
        self._reader.join(PATIENCE)

    def _read(self) -> None:
        while self.status is None:
            try:
                message = self.command.messages.get(timeout=PATIENCE)
            except queue.Empty:
                message = {"status": -1, "err": f"silent for {PATIENCE:.0f} s\n"}
            with self._changed:
                self._take(message)
                self._changed.notify_all()

    def _take(self, message: dict[str, Any]) -> None:
        for text in message.get("out", "").splitlines():
            line = json.loads(text)
            if line["gap"]:
                self.gaps[line["reason"]["en"]] += 1
            else:
                values = {name: it for name, it in line["values"].items() if it is not None}
                self.sets.append((line["time"], values))
                self.latest = line["time"]
        self.notes += message.get("err", "")
        if state := message.get("state"):
            self.clock.compare(self._asked, state["time"], now := NOW.now())
            self.memory.append((now, state["rss"]))
            self._asked = 0.0
        self.status = message.get("status", self.status)


@dataclass
class Verdict:
    """What the host finds in one file, and its `mistakes`."""

    log: Log
    given: Given
    values: int = 0
    rows: int = 0
    mistakes: list[str] = field(default_factory=list)

    def judge(self) -> None:
        """Compare the file with what the unit gave, what was printed, and `mikas decode`."""
        recorded = self._recorded()
        self._printed(recorded)
        self._decoded()
        found = summarise(self.log.file)
        if found.problem or found.recordings != 1:
            self.mistakes.append(f"{self.log.file.name}: {found}")

    def _recorded(self) -> dict[str, tuple[list[float], list[float]]]:
        """Check each recorded value; return times and values by name."""
        recording = mikas.open(self.log.file)
        if recording.problem_count:
            self.mistakes.append(f"damage in {self.log.file.name}: {recording.problems[:3]}")
        columns: dict[str, tuple[list[float], list[float]]] = {}
        latest = 0.0
        for stretch in recording.rows():
            self.rows += len(stretch.times)
            for name, column in stretch.values.items():
                if name in recording.catalog.derived:
                    continue
                times, values = columns.setdefault(name, ([], []))
                for time, value in zip(stretch.times.tolist(), column.tolist(), strict=True):
                    if not isnan(value):
                        times.append(time)
                        values.append(value)
            if len(stretch.times) and stretch.times[0] < latest:
                self.mistakes.append(f"time runs back at {stretch.times[0]:.6f}")
            latest = float(stretch.times[-1]) if len(stretch.times) else latest
        for name, (times, values) in columns.items():
            self.values += len(times)
            for time, value in zip(times, values, strict=True):
                host = self.log.clock.host(time)
                if not self.given.is_value(name, value, host, host):
                    self.mistakes.append(f"recorded {name}={value} at {time:.6f} was never given")
        return columns

    def _printed(self, recorded: dict[str, tuple[list[float], list[float]]]) -> None:
        """Check that each printed set is in the recording, at its time, and is right."""
        latest = 0.0
        for time, printed in self.log.sets:
            if time <= latest:
                self.mistakes.append(f"printed time runs back at {time:.6f}")
            latest = time
            host = self.log.clock.host(time)
            begins = False
            for name, value in printed.items():
                times, values = recorded.get(name, ([], []))
                at = bisect_left(times, time - SAME)
                begins |= at < len(times) and times[at] < time + SAME
                last = bisect_left(times, time + CYCLE)
                if not any(abs(it - value) < 1e-6 for it in values[at:last]):
                    self.mistakes.append(f"printed {name}={value} at {time:.6f} is not recorded")
                if not self.given.is_value(name, value, host, host + CYCLE):
                    self.mistakes.append(f"printed {name}={value} at {time:.6f} was never given")
            if not begins:
                self.mistakes.append(f"no response recorded at {time:.6f}, of a printed set")

    def _decoded(self) -> None:
        """Check that `mikas decode` finds as many responses with data."""
        words = (sys.executable, "-m", "mikas", "decode", str(self.log.file), "--json")
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        frames = [json.loads(line) for line in done.stdout.splitlines()]
        data = [
            frame
            for frame in frames
            if frame["type"] == "frame" and frame["direction"] == "received" and not frame["echo"]
            if (frame["request"] or "")[:2] in {"61", "63", "71"} and frame["body"] != "01"
        ]
        if done.returncode or len(data) != self.rows:
            self.mistakes.append(
                f"mikas decode: status {done.returncode}, {len(data)} responses with data, "
                f"{self.rows} rows; {done.stderr}"
            )


def received(log: Log) -> list[tuple[float, bytes]]:
    """Return the bytes in the file that came from the adapter, with the host's time."""
    packets = [item for item in CaptureReader(log.file) if isinstance(item, Packet)]
    return [
        (log.clock.host(packet.time), packet.data)
        for packet in packets
        if packet.direction is Direction.RECEIVED
    ]


def lost_at_the_end(parts: list[bytes], delivered: bytes) -> int | None:
    """Return how many bytes at the end of `delivered` are in no recording; None: others miss, too.

    `parts`: those that the recordings have of one plugging-in, one for each file.
    """
    at = 0
    for number, part in enumerate(parts, start=1):
        find = delivered.rfind if number == len(parts) else delivered.find
        begin = find(part, at)
        if begin < 0:
            return None
        at = begin + len(part)
    return len(delivered) - at
