"""Killed by `kill -9` at random moments: what is left of recordings, dumps, journal and settings.

The children are forks of this process, which has everything imported. They run the real commands
on pseudo-terminals whose units this process serves, so what a unit has sent is known here and is
compared with the files. `bench/full_disk.py` is the same for a disk without room.

python -m bench.themes.crash KILLS SEED     a campaign; prints every loss
"""

from __future__ import annotations

import asyncio
import json
import os
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from random import Random

import mikas
from bench import full_disk
from bench.rows import Row, Scope, Theme
from mikas.catalog import shipped
from mikas.catalog.starter import starter_catalog
from mikas.cli.failures import BUG
from mikas.cli.main import run as run_command
from mikas.client.gate import add_to_journal
from mikas.client.limits import Limits, LimitsStore
from mikas.client.memory.dumps import manifest_path, read_manifest
from mikas.link.base import Direction
from mikas.recording.capture.reader import CaptureReader, Packet, Problem
from mikas.saving import save
from mikas.virtual import serve
from mikas.virtual.build import build_bus
from mikas.virtual.ecu import EcuEvent

SEED = 1
_LANES = 20  # children at a time; they mostly wait for their line
_FAST = "115200"  # baud, where only the files matter
_PATIENT = ("--timeout", "9", "--inter-byte", "3")  # this process serves while it compares
_LONGEST = 60.0  # s, to wait for answers
_DUMPED = 0x300  # bytes
_METHOD = """\
`kill -9` at random moments, {kills:,} times (seed {seed}), in real time: `mikas log` at 9600 baud,
`mikas mem dump` and its --resume, changes of the unit's memory with their journal, each on a
virtual unit of its own behind a pty; and a program that does nothing but save (learnt limits, a
catalog, presets), in a loop. What the unit had sent, or the program had reported, is compared
with the files. A recording has a loss if a byte that was received more than a second before the
kill is missing or differs, or if the file can't be read; a dump, if it can't be gone on with to the
same bytes; a journal, if an entry of a change that was begun or reported is missing, or the next
entry is not readable; a saved file, if it is neither the old one nor the new one."""


def run(scope: Scope) -> Iterator[Theme]:
    kills = scope.of(1000, 24)
    found = serve.run(_campaign(kills, SEED))
    rows = [
        Row(f"{name}: losses", [each.lost], "", 0, at_most=0, aside=each.aside())
        for name, each in found.items()
    ]
    yield Theme("Killed at any moment", _METHOD.format(kills=kills, seed=SEED), rows)
    yield full_disk.measured(scope.of(100, 10), SEED)


@dataclass
class Kills:
    """What one kind of killed program has left. `states`: in which states its files were."""

    count: int = 0
    lost: int = 0
    checked: int = 0
    unit: str = ""
    states: Counter[str] = field(default_factory=Counter)

    def aside(self) -> str:
        states = ", ".join(f"{count} {name}" for name, count in sorted(self.states.items()))
        return f"{self.count} kills, {self.checked:,} {self.unit} compared; {states}"


class Unit:
    """A virtual unit on a pty. `sent`: what it put into the pty, and when; `answers`: how many."""

    def __init__(self, **settings: str) -> None:
        self.bus = build_bus(settings, start=time.time(), watcher=self._heard)
        self.sent: list[tuple[float, bytes]] = []
        self.answers = self.writes = 0
        self.port = _Tapped(self.bus, time.time)
        self.port.sent = self.sent
        self.url = self.port.url

    def _heard(self, event: EcuEvent) -> None:
        self.answers += event.kind == "response"
        self.writes += event.kind == "request" and event.data[:1] in (b"\x22", b"\x12")


class _Tapped(serve.PtyPort):
    sent: list[tuple[float, bytes]]

    def _send(self, data: bytes) -> None:
        count = 0
        with suppress(BlockingIOError):
            count = os.write(self._master, data)
        self.sent.append((time.time(), data[:count]))


@contextmanager
def unit(**settings: str) -> Iterator[Unit]:
    """Serve a unit for one child."""
    made = Unit(**settings)
    try:
        yield made
    finally:
        made.port.close()


def forked(act: Callable[[], int], said: Path) -> int:
    """Run `act` in a fork, with its words in the file `said`; return its process id."""
    if child := os.fork():
        return child
    status = BUG
    try:
        asyncio.events._set_running_loop(None)  # noqa: SLF001  (it is the parent's)
        words = os.open(said, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(words, 1)
        os.dup2(words, 2)
        status = act()
        sys.stdout.flush()
    except BaseException:
        traceback.print_exc()
        sys.stderr.flush()
    finally:
        os._exit(status)


async def killed(
    child: int, seconds: float, on: Unit | None = None, answers: int = 0
) -> float | None:
    """Kill the child so long after the unit's so many answers; return when. None: it had ended."""
    until = time.monotonic() + _LONGEST
    while on is not None and on.answers < answers and time.monotonic() < until:
        await asyncio.sleep(0.005)
        if os.waitid(os.P_PID, child, os.WEXITED | os.WNOHANG | os.WNOWAIT):
            break
    await asyncio.sleep(seconds)
    now = time.time()
    os.kill(child, signal.SIGKILL)
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    return now if status == -signal.SIGKILL else None


async def ended(child: int) -> int:
    """Wait for the child; return its status."""
    while True:
        pid, status = os.waitpid(child, os.WNOHANG)
        if pid:
            return os.waitstatus_to_exitcode(status)
        await asyncio.sleep(0.02)


async def _campaign(kills: int, seed: int) -> dict[str, Kills]:
    kinds: dict[str, tuple[Callable[[Path, Random, Kills], Awaitable[str]], Kills]] = {
        "`log`": (_log, Kills(unit="received bytes")),
        "`mem dump`": (_dump, Kills(unit="bytes")),
        "changes and their journal": (_journal, Kills(unit="entries")),
        "saved files": (_saved, Kills(unit="files")),
    }
    names = list(kinds)
    turns = [(number, names[min(number % 10 // 2, 3)]) for number in range(kills)]
    with tempfile.TemporaryDirectory(prefix="mikas-crash-") as folder:
        os.environ["MIKAS_STATE"] = f"{folder}/state"

        async def lane() -> None:
            while turns:
                number, name = turns.pop()
                act, found = kinds[name]
                place = Path(folder) / str(number)
                place.mkdir()
                found.count += 1
                try:
                    state = await act(place, Random(f"{seed}:{number}"), found)
                except Exception as error:  # a file that can't be read, whatever the reason
                    found.lost += 1
                    state = f"lost ({type(error).__name__})"
                    print(f"{name}, case {number}: {error!r}", file=sys.stderr)
                found.states[state] += 1

        await asyncio.gather(*(lane() for _ in range(_LANES)))
    return {name: found for name, (_, found) in kinds.items()}


async def _log(place: Path, random: Random, found: Kills) -> str:
    file = place / "drive.pcapng"
    method = random.choice(("single", "batch", "list"))
    with unit() as on:
        words = ["log", "-o", str(file), "--port", on.url, "--method", method, *_PATIENT]
        child = forked(lambda: run_command(words), place / "said")
        at = await killed(child, random.uniform(0, 1.2), on, random.randrange(90))
        assert at is not None, (place / "said").read_text("utf-8")
        certain = b"".join(data for when, data in on.sent if when < at - 1)
    if not file.exists():
        assert not certain, "there is no recording"
        return "not begun"
    items = list(CaptureReader(file))
    kept = b"".join(
        item.data
        for item in items
        if isinstance(item, Packet) and item.direction is Direction.RECEIVED
    )
    assert kept.startswith(certain), f"{len(certain)} bytes are not the first of {len(kept)}"
    found.checked += len(certain)
    cut = any(isinstance(item, Problem) for item in items)
    return "with a cut last block" if cut else "whole"


async def _dump(place: Path, random: Random, found: Kills) -> str:
    file = place / "xram.bin"
    with unit(baud=_FAST) as on:
        words = ["mem", "dump", "xram", "-o", str(file), "--to", f"{_DUMPED - 1:X}"]
        words += ["--port", on.url, "--block", "16", *_PATIENT]
        resume: list[str] = []
        state = ""
        for _ in range(2):  # the second time it is gone on with, and killed again
            command = [*words, *resume]
            child = forked(partial(run_command, command), place / "said")
            at = await killed(child, random.uniform(0, 0.02), on, on.answers + random.randrange(50))
            size = file.stat().st_size if file.exists() else 0
            state = state or ("not begun" if not size else "in part" if at else "complete")
            resume = ["--resume"] if file.exists() or manifest_path(file).exists() else []
        status = await ended(forked(lambda: run_command([*words, *resume]), place / "said"))
        assert status == 0, (place / "said").read_text("utf-8")
        whole = on.bus.ecu.responder.memory.read("xram", 0, _DUMPED)
    assert file.read_bytes() == whole
    manifest = read_manifest(file)
    assert manifest is not None
    assert manifest.complete
    found.checked += len(whole)
    return state


async def _journal(place: Path, random: Random, found: Kills) -> str:
    path, told = place / "journal.jsonl", place / "told"

    def change() -> int:
        done = os.open(told, os.O_WRONLY | os.O_CREAT)
        with mikas.connect(on.url, journal=path, confirm=lambda _: True, timeout=9) as ecu:
            for number in range(1 << 16):
                ecu.memory.ram.write_block(0x40, number.to_bytes(2) * 16)
                os.write(done, b".")
        return 0

    with unit(baud=_FAST) as on:
        child = forked(change, place / "said")
        await killed(child, random.uniform(0, 0.02), on, random.randrange(250))
        heard = on.writes
    reported = told.stat().st_size if told.exists() else 0
    text = path.read_text("utf-8") if path.exists() else ""
    entries = [json.loads(line) for line in text.splitlines()[: text.count("\n")]]
    states = Counter(entry["state"] for entry in entries)
    assert states["done"] >= reported, f"{states['done']} of {reported} outcomes"
    assert states["started"] >= reported
    assert states["started"] or not heard, "a change without an entry"
    add_to_journal(path, {"state": "next"})
    assert json.loads(path.read_text("utf-8").splitlines()[-1]) == {"state": "next"}
    found.checked += len(entries)
    return "whole" if text.endswith("\n") or not text else "with a cut last line"


async def _saved(place: Path, random: Random, found: Kills) -> str:
    store = LimitsStore(place)
    kinds = [Limits(), Limits(max_list=7, refused=list(range(200)))]
    data = [{code: bytes([code, code]) for code in range(last)} for last in (16, 200)]
    texts = [starter_catalog(codes, shipped(), ["found"], "ru") for codes in data]
    presets = [json.dumps([{"names": ["TWAT"] * count}]) for count in (1, 5000)]

    def save_for_ever() -> int:
        for number in range(1 << 30):
            store.save(0x0A, ("A", "B"), kinds[number % 2])
            save(place / "catalog.toml", texts[number % 2])
            save(place / "presets", presets[number % 2])
        return 0

    assert await killed(forked(save_for_ever, place / "said"), random.uniform(0.01, 0.4))
    left = sum(path.suffix == ".new" for path in place.iterdir())
    for name, contents in (("catalog.toml", texts), ("presets", presets)):
        with suppress(FileNotFoundError):
            assert (place / name).read_text("utf-8") in contents, name
            found.checked += 1
    for file in place.glob("*.json"):
        json.loads(file.read_text("utf-8"))
        assert store.load(0x0A, ("A", "B")) in kinds
        found.checked += 1
    save(place / "catalog.toml", texts[0])
    store.save(0x0A, ("A", "B"), kinds[1])
    save(place / "presets", presets[0])
    assert not any(path.suffix == ".new" for path in place.iterdir())
    return "with a temporary file, gone at the next saving" if left else "whole"


def main() -> None:
    kills, seed = (*map(int, sys.argv[1:]), 1000, SEED)[:2] if sys.argv[1:] else (1000, SEED)
    for name, each in serve.run(_campaign(kills, seed)).items():
        print(f"{name}: {each.lost} losses; {each.aside()}")


if __name__ == "__main__":
    main()
