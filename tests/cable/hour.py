"""`mikas log` in real time while its cable is pulled out and put back at random: `make hour`.

    PYTHONPATH=tests python -m cable.hour --minutes 60 --seed 1

In the box (docs/development/cable.md), for so many minutes: the cable is pulled at a random byte
or moment and put back after 0.3 to 20 s, sometimes with a stranger beside it or on its name; the
ignition goes off and on. After a twelfth of the time `log` is killed (-9) and started again, at
the end Ctrl-C.

Prints a table of figures. Exit status 1 on a mistake: a value that the unit did not give, a printed
set that is not recorded, lost bytes, a stranger that was opened, values that do not come back in
time, memory that grows. The same seed gives the same order of events, not the same bytes.
"""

from __future__ import annotations

import argparse
import compileall
import shutil
import sys
from collections import Counter
from dataclasses import dataclass, field
from random import Random
from statistics import median
from time import sleep

from bench.soak import NAMES
from bench.soak_car import Outages, SoakCar

from cable.box_rig import Box
from cable.hour_judge import (
    NOW,
    ON_ITS_WAY,
    Given,
    GuestClock,
    Log,
    Verdict,
    lost_at_the_end,
    received,
)
from cable.image_rig import REPOSITORY, missing
from mikas.virtual.responder import Identity, Responder

FOLDER = REPOSITORY / "build" / "hour"
BACK = 20.0  # s from plugging in to the first set, while the ignition is on
GROWTH = 1024  # KiB that the memory may grow after `WARM`
WARM = 600.0  # s, but at most a third of the time
_LOOK = 5.0  # s between two looks at clock and memory
_REPORT = 300.0  # s between two lines of progress
_SHOWN = 100  # mistakes
_START = 40.0  # s with the ignition on, for `log` to start


@dataclass
class Hour:
    """One run. `mistakes`: empty if all was right."""

    box: Box
    minutes: float
    random: Random
    seed: int
    mistakes: list[str] = field(default_factory=list)
    logs: list[Log] = field(default_factory=list)
    pulls: Counter[str] = field(default_factory=Counter)  # by the kind of moment
    strangers: Counter[str] = field(default_factory=Counter)
    back: list[float] = field(default_factory=list)  # s from plugging in to the first set
    plugged: list[float] = field(default_factory=list)  # times
    exact: set[int] = field(default_factory=set)  # pluggings-in that ended at an exact byte
    losses: list[int] = field(default_factory=list)  # bytes at each of these
    memory: tuple[int, int] = (0, 0)  # KiB of the last `log`: warm, and at the end

    def __post_init__(self) -> None:
        self.clock = GuestClock()
        self.ignition = Outages(
            (40, 200), (0.5, 8), Random(f"{self.seed} ignition"), start=NOW.now() + _START
        )
        self.car = SoakCar(self.seed, self.ignition)
        identity = Identity(0x0A, ("MIKAS",) * 8)
        # D16, exaggerated: the emulated computer can't follow more than some 30 responses a second.
        self.cable = self.box.cable(unit=Responder(self.car, identity), stream_load="60")
        # Only its data are different: a value of it is a mistake that shows.
        other = SoakCar(self.seed + 1, Outages((1e9, 1e9), (1, 1), Random(0), start=NOW.now()))
        self.stranger = self.box.cable(1, serial="FTG7X2QD", unit=Responder(other, identity))
        self.stranger_is_in = False

    def run(self) -> None:
        began = reported = NOW.now()
        self._plug()
        for method, share, signal, status in (("stream", 1 / 12, 9, -9), ("auto", 1, 2, 130)):
            log = self._start(method)
            while NOW.now() < began + self.minutes * 60 * share and log.status is None:
                self._disturb(log)
                if NOW.now() >= reported + _REPORT:
                    reported = NOW.now()
                    self._report(reported - began)
            if log.status is None:
                log.end(signal)
            if log.status != status:
                self.mistakes.append(f"log ended with {log.status}: {log.notes[-2000:]}")
                return

    def judge(self) -> list[Verdict]:
        given = Given(self.car)
        verdicts = [Verdict(log, given) for log in self.logs]
        for verdict in verdicts:
            verdict.judge()
            self.mistakes += verdict.mistakes
        self.losses = self._losses()
        if self.stranger.wire.sent:
            self.mistakes.append(f"sent to the stranger: {self.stranger.wire.sent.hex(' ')}")
        self.memory = self._memory()
        if self.memory[1] - self.memory[0] > GROWTH:
            self.mistakes.append("memory from {} to {} KiB".format(*self.memory))
        return verdicts

    def _report(self, seconds: float) -> None:
        sets, pulls = sum(len(log.sets) for log in self.logs), self.pulls.total()
        print(f"{seconds / 60:.0f} min: {sets:,} sets, pulled out {pulls} times", flush=True)
        for mistake in self.mistakes:
            print(f"  {mistake}", flush=True)

    # What is done

    def _start(self, method: str) -> Log:
        while self.box.lines.call(lambda: self.ignition.begin) < NOW.now() + _START:
            sleep(1)
        file = self.box.home / f"{len(self.logs) + 1}-{method}.pcapng"
        words = ("mikas", "--port", f"/dev/{self.cable.name}", "log", "-o", str(file), "--json")
        command = self.box.start(*words, "--method", method, *NAMES)
        log = Log(command, file, self.clock)
        self.logs.append(log)
        log.ask_state()
        if not log.has_set_after(0.0, 2 * BACK):
            self.mistakes.append(f"no set after the start: {log.notes[-2000:]}")
        return log

    def _disturb(self, log: Log) -> None:
        """Pull the cable and put it back."""
        self._wait(log, self.random.uniform(1, 15))
        if self.stranger_is_in and self.random.random() < 0.5:
            self._pull_stranger()
        elif not self.stranger_is_in and self.random.random() < 0.15:
            self._plug_stranger("beside it")
        self._pull()
        if not self.stranger_is_in and self.random.random() < 0.2:
            self._plug_stranger("in its place")
        self._wait(log, 0.3 * (20 / 0.3) ** self.random.random())
        begin = self._plug()
        if self.random.random() < 0.2:
            self._wait(log, self.random.uniform(0, 3))  # and pull it again, wherever `log` is
        else:
            self._wait_for_values(log, begin)

    def _pull(self) -> None:
        # A stream goes on while `log` has not opened the port: then no byte is exact.
        seen = None
        if self.random.random() < 0.7 and self.cable.was_opened:
            number = self.random.randint(1, 60)
            seen = self.cable.cut_when(lambda seen: len(seen) == number)()
        else:
            self.cable.pull()
        if seen is None:
            self.pulls["at any moment"] += 1
        else:
            self.pulls[self._kind(seen)] += 1
            self.exact.add(len(self.plugged) - 1)

    def _kind(self, seen: bytes) -> str:
        """Return what the byte was at which the cable was cut."""
        partial = seen.rpartition(b"\r")[2]
        if not partial:
            return "between two frames"
        request = bytes(self.cable.wire.sent).rstrip(b"\r").rpartition(b"\r")[2]
        return "in an echo" if request.startswith(partial) else "in a response"

    def _plug(self) -> float:
        """Return when the cable had its name in the guest."""
        self.plugged.append(NOW.now())
        self.cable.plug()
        return NOW.now()

    def _plug_stranger(self, where: str) -> None:
        self.stranger.plug()
        self.stranger_is_in = True
        self.strangers[where] += 1
        if where == "in its place" and self.stranger.name == "ttyUSB0":
            self.strangers["with its name"] += 1

    def _pull_stranger(self) -> None:
        if self.stranger.was_opened:
            self.mistakes.append("the stranger's port was opened")
        self.stranger.pull()
        self.stranger_is_in = False

    def _wait_for_values(self, log: Log, begin: float) -> None:
        known = max(0, len(log.sets) - 100)  # a set may have come while the port got its name
        while not log.has_set_after(begin, _LOOK):
            log.ask_state()
            if log.status is not None:
                return
            if self._without_ignition_off(begin) > BACK:
                self.mistakes.append(
                    f"no set {BACK:.0f} s after plugging in at {begin:.3f}: {log.notes[-500:]}"
                )
                return
        times = (self.clock.host(time) for time, _ in log.sets[known:])
        first = next(time for time in times if time >= begin)
        self.back.append(self._without_ignition_off(begin, first))

    def _without_ignition_off(self, begin: float, end: float | None = None) -> float:
        end = NOW.now() if end is None else end
        return end - begin - self.box.lines.call(lambda: self.ignition.seconds_in(begin, end))

    def _wait(self, log: Log, seconds: float) -> None:
        end = NOW.now() + seconds
        while (left := end - NOW.now()) > 0:
            log.ask_state()
            sleep(min(left, _LOOK))

    # What is looked at after that

    def _losses(self) -> list[int]:
        """Return the bytes lost at each pull at an exact byte."""
        losses = []
        packets = [received(log) for log in self.logs]
        ends = [*self.plugged[1:], float("inf")]
        delivered = self.cable.wire.delivered
        for number, (begin, end) in enumerate(zip(self.plugged, ends, strict=True)):
            parts = [
                b"".join(data for time, data in each if begin <= time < end) for each in packets
            ]
            if not (parts := [part for part in parts if part]):
                continue  # pulled before the port was opened
            lost = lost_at_the_end(parts, bytes(delivered[number]))
            if lost is None or (number in self.exact and lost > ON_ITS_WAY):
                self.mistakes.append(f"plugging-in {number} at {begin:.3f}: bytes lost: {lost}")
            elif number in self.exact:
                losses.append(lost)
        return losses

    def _memory(self) -> tuple[int, int]:
        """Return the KiB of the last `log`, after it has warmed up and at the end."""
        samples = self.logs[-1].memory
        begin, end = samples[0][0], samples[-1][0]
        warm = begin + min(WARM, (end - begin) / 3)
        rested = [rss for time, rss in samples if time >= warm]
        return round(median(rested[:5])), round(median(rested[-5:]))


def table(hour: Hour, verdicts: list[Verdict], seconds: float) -> str:
    """Return the figures in markdown."""
    sets = [log.sets for log in hour.logs]
    gaps = sum((log.gaps for log in hour.logs), Counter[str]())
    delivered = sum(map(len, hour.cable.wire.delivered))
    rows: dict[str, object] = {
        "seed": hour.seed,
        "real time": f"{seconds / 60:.1f} min",
        "sets printed": f"{sum(map(len, sets)):,}",
        "values printed": f"{sum(len(values) for each in sets for _, values in each):,}",
        "responses with data recorded": f"{sum(it.rows for it in verdicts):,}",
        "values recorded": f"{sum(it.values for it in verdicts):,}",
        "**mistakes**": f"**{len(hour.mistakes)}**",
        "cable pulled out": f"{hour.pulls.total()}: "
        + ", ".join(f"{count} {kind}" for kind, count in sorted(hour.pulls.items())),
        "another cable": ", ".join(f"{n} {kind}" for kind, n in sorted(hour.strangers.items()))
        or "0",
        "ignition off": hour.ignition.count,
        "values back after plugging in": f"median {median(hour.back or [0]):.1f} s, "
        f"longest {max(hour.back, default=0):.1f} s of {len(hour.back)}",
        "bytes lost with the device": f"{sum(hour.losses)} of {delivered:,}, "
        f"at most {max(hour.losses, default=0)} at a pull",
        "memory of `log`": f"{hour.memory[0]:,} KiB warm, {hour.memory[1]:,} KiB at the end",
        "oldest value": f"{verdicts[0].given.oldest:.2f} s",
        "clocks compared to": f"{hour.clock.error:.2f} s",
        **{f"failed cycles: {reason}": count for reason, count in gaps.most_common()},
        **{f"`{log.file.name}`": log.notes.strip().rpartition("\n")[2] for log in hour.logs},
    }
    return "\n".join(["| | |", "|---|---|", *(f"| {name} | {it} |" for name, it in rows.items())])


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m cable.hour", description=__doc__)
    parser.add_argument("--minutes", type=float, default=60)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    if reason := missing():
        sys.exit(reason)
    compileall.compile_dir(REPOSITORY / "src", quiet=1)  # the guest can't write there
    shutil.rmtree(FOLDER, ignore_errors=True)
    FOLDER.mkdir(parents=True)
    box = Box(FOLDER)
    try:
        hour = Hour(box, given.minutes, Random(given.seed), given.seed)
        began = NOW.now()
        hour.run()
    except AssertionError as error:  # of the rigs, which wait for the guest
        hour.mistakes.append(f"stopped: {error}")
    finally:
        box.close()
    seconds = NOW.now() - began
    print(table(hour, hour.judge(), seconds))
    for mistake in hour.mistakes[:_SHOWN]:
        print(f"MISTAKE: {mistake}")
    print(f"The recordings are in {FOLDER}")
    return 1 if hour.mistakes else 0


if __name__ == "__main__":
    sys.exit(main())
