"""One drive by each of the programs, as text that a diff shows well.

What repeats is shortened: samples to their number, their times and a hash; a state of the dashboard
to what is new in it; bytes on the wire to their number and a hash.
"""

from __future__ import annotations

import asyncio
import hashlib
import io
import json
from collections.abc import Iterable, Iterator
from contextlib import redirect_stderr, redirect_stdout
from itertools import groupby
from pathlib import Path
from typing import Any

import pytest

from golden.garage_rig import CABLE, Drive, Garage
from mikas.catalog import shipped
from mikas.cli.context import CommandContext
from mikas.cli.language import set_language
from mikas.cli.main import run
from mikas.cli.port_ahead import PortAhead
from mikas.dashboard.api import live
from mikas.dashboard.api.live import Broadcaster, Listener
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.security.control import Client
from mikas.dashboard.settings import PlanSettings, Settings
from mikas.link import WallClock
from mikas.publish.connection import BrokerChange
from mikas.publish.outbox import Message, MessageKind, Outbox
from mikas.recording import CaptureReader
from mikas.recording.capture.reader import Packet
from mikas.recording.recording import Recording

CHANNELS = ("FREQ", "TWAT/4", "MINERR", "FUEL_FLOW")
RATE = "5"
CATALOG = "1+ourcatal"  # in the place of its version, which each edit of a text changes
TICK = 2.0  # s between two messages of the dashboard


def equip(patch: pytest.MonkeyPatch, garage: Garage, folder: Path) -> None:
    """Let the program run in this garage, with its files in `folder`, in English."""
    for name in ("MIKAS_CONFIG", "MIKAS_LANG", "LC_ALL", "LC_MESSAGES", "NO_COLOR", "COLUMNS"):
        patch.delenv(name, raising=False)
    patch.setenv("LANG", "C.UTF-8")
    patch.setenv("MIKAS_LANG", "en")
    for name in ("HOME", "USERPROFILE", "XDG_CONFIG_HOME"):
        patch.setenv(name, str(folder / "home"))
    patch.setenv("MIKAS_STATE", str(folder / "state"))
    patch.setenv("MIKAS_PORT", CABLE.url)
    patch.chdir(folder)
    patch.setattr("importlib.metadata.version", lambda _: "golden")  # of the program, in files
    patch.setattr(CommandContext, "open_ahead", lambda it, _=(): PortAhead(it.port, garage.open))
    garage.equip(patch)
    set_language("en")


# The command line


def command(drive: Drive, folder: Path, *argv: str) -> str:
    """Run `mikas *argv` with the options of the drive."""
    out, err = io.StringIO(), io.StringIO()
    with pytest.MonkeyPatch.context() as patch:
        equip(patch, drive.garage(), folder)
        options = ("--rate", RATE, "--method", drive.method, "--duration", str(drive.seconds))
        with redirect_stdout(out), redirect_stderr(err):
            status = run([*argv, *CHANNELS, *options, "--json"])
    lines = [json.loads(line) for line in out.getvalue().splitlines()]
    return _text("status", [status], "stdout", _shortened(lines), "stderr", [err.getvalue()])


def log(drive: Drive, folder: Path) -> str:
    """`mikas log`: JSON lines, notices, and the files with what a reader finds in them."""
    return command(drive, folder, "log", "-o", "drive.pcapng") + "".join(_files(folder))


def watch(drive: Drive, folder: Path) -> str:
    """`mikas watch`: JSON lines and notices."""
    return command(drive, folder, "watch")


class Broker:
    """Gets every message at once; in the place of `BrokerConnection`."""

    got: list[Message]

    def __init__(self, _: object, outbox: Outbox, *, on_change, online, offline, **more) -> None:
        self.sent, self.is_connected = 0, False
        self._outbox, self._on_change = outbox, on_change
        self._online, self._offline = online, offline

    def open(self, *, patient: bool = False) -> None:
        self.is_connected = True
        self._outbox.connected()
        self.send([])
        self.got.append(self._online)
        self._on_change(BrokerChange())

    def send(self, messages: Iterable[Message]) -> None:
        self._outbox.put(messages)
        while (message := self._outbox.next()) is not None:
            self.got.append(message)
            self._outbox.sent(message)
            self.sent += 1

    def close(self) -> None:
        self.send([])
        self.got.append(self._offline)


def publish(drive: Drive, folder: Path) -> str:
    """`mikas publish`: what it prints, and the messages that the broker gets."""
    Broker.got = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("mikas.publish.session.BrokerConnection", Broker)
        printed = command(drive, folder, "publish", "mqtt://broker", "--samples", "--every", "2")
    return printed + _text("messages", map(_published, Broker.got))


def _published(message: Message) -> str:
    payload = message.payload.decode()
    if message.kind is MessageKind.SAMPLES:
        rows = json.loads(payload)
        payload = f"first {rows['first']}, rows {len(rows['samples'])}, {_hash(payload)}"
    return f"{message.topic} {payload}"


# The dashboard


def dashboard(drive: Drive, folder: Path) -> str:
    """The WebSocket's messages every two seconds, while a recording is made of a part; its file."""
    garage = drive.garage()
    with pytest.MonkeyPatch.context() as patch:
        equip(patch, garage, folder)
        patch.setattr(live, "PERIOD", 3600.0)  # only this rig lets messages be made
        told = asyncio.run(_visit(drive, garage, folder))
    return _text("messages", told) + "".join(_files(folder))


async def _visit(drive: Drive, garage: Garage, folder: Path) -> list[str]:
    settings = Settings(
        folder,
        state=folder / "state",
        find=garage.find,
        open_port=garage.open,
        wall=WallClock(garage.now, garage.now),
    )
    it = Dashboard(settings, port=CABLE.url, clock=garage.now)
    wanted = [name.partition("/") for name in CHANNELS]
    every = {name: int(each or 1) for name, _, each in wanted}
    it.plan.request = PlanSettings(every, drive.method, float(RATE))
    viewer = _Viewer(it)
    running = it.running()
    garage.hold_next()
    await running.__aenter__()
    await garage.held()
    viewer.come()
    time = 0.0
    while (time := time + TICK) < drive.seconds:
        garage.until(time)
        viewer.look()
        if time == 2 * TICK:
            recording = asyncio.create_task(it.recorder.start("drive"))
            await _others()
        if time == 3 * TICK:
            it.recorder.marker("here")
    await recording
    if drive.name == "unplugging":
        await _change_and_return(it, garage, viewer)
    await it.connection.close()
    it.recorder.stop()
    viewer.look()
    viewer.leave()
    await running.__aexit__(None, None, None)
    return viewer.seen


async def _change_and_return(it: Dashboard, garage: Garage, viewer: _Viewer) -> None:
    """Choose other channels, connect to the same cable once more, disconnect, and return."""

    it.plan.sample(PlanSettings({"FREQ": 1, "MINERR": 1}, "list", 4.0))
    garage.until(garage.now() + 3)
    viewer.look()
    await _connect(it, garage, viewer)
    leaving = asyncio.create_task(it.disconnect())
    await _until_read(it, garage)
    await leaving
    viewer.look()
    garage.stand(5)
    await _connect(it, garage, viewer)


async def _connect(it: Dashboard, garage: Garage, viewer: _Viewer) -> None:
    """Connect to the cable, once more if need be, and look on for three seconds."""
    connecting = asyncio.create_task(it.connect(garage.find()[0].url, method="batch", rate=4.0))
    if it.recorder.file_name is not None:
        await _until_read(it, garage)
    garage.hold_next()
    await garage.held()
    garage.until(garage.now() + 3)
    await connecting
    viewer.look()


async def _until_read(it: Dashboard, garage: Garage) -> None:
    """Go on until the stored faults are read, as another task wants by now."""
    await _others()
    before = garage.now()
    garage.hold_when(lambda: it.fault_history.latest.time > before)


async def _others() -> None:
    """Let the other tasks come as far as they can."""
    for _ in range(20):
        await asyncio.sleep(0)


class _Viewer:
    """A client of the WebSocket."""

    def __init__(self, it: Dashboard) -> None:
        self.seen: list[str] = []
        self._broadcaster = Broadcaster(it)
        self._listener = Listener(Client("golden", "", False), "page")
        self._state: dict[str, Any] = {}

    def come(self) -> None:
        self._broadcaster.join(self._listener)
        self._listener.waiting.clear()

    def leave(self) -> None:
        self._broadcaster.leave(self._listener)

    def look(self) -> None:
        self._broadcaster.tick()
        while self._listener.waiting:
            self._take(json.loads(self._broadcaster.message(self._listener)))

    def _take(self, message: dict[str, Any]) -> None:
        state, data = message.pop("state", {}), message.pop("data", None)
        events = message.pop("events", [])
        self.seen.append(_json(message))
        if data is not None:
            times = data["times"]
            shown = f"{len(times)} rows of {' '.join(data['names'])}, {times[0]}–{times[-1]}"
            self.seen.append(f"  {shown}, {_hash(_json(data))}")
        self.seen += [f"  {_json(event)}" for event in events]
        new = {key: it for key, it in state.items() if key not in self._state
               or self._state[key] != it}  # fmt: skip
        self._state |= new
        if new:
            self.seen.append(f"  state {_json(new)}")


# As text


def _files(folder: Path) -> Iterator[str]:
    """The recordings: their bytes, their notes, and the events that a reader makes of them."""
    for path in sorted(folder.glob("*.pcapng")):
        content = path.read_bytes().replace(shipped().version.encode(), CATALOG.encode())
        reader = CaptureReader(path)
        packets = [it for it in reader if isinstance(it, Packet)]
        sides = {it.direction for it in packets}
        counts = [
            f"{len(content)} bytes, {_hash(content)}",
            *sorted(f"{sum(len(p.data) for p in packets if p.direction is it)} {it.value}"
                    for it in sides),
        ]  # fmt: skip
        notes = [_json([it.kind, it.time, it.data]) for it in CaptureReader(path).notes()]
        events = [_json(it.as_json()) for it in Recording(path, shipped()).events]
        yield _text(path.name, counts, f"{path.name}: notes", notes, f"{path.name}: events", events)


def _shortened(lines: Iterable[dict[str, Any]]) -> Iterator[str]:
    """Samples in a row: the first, and how many of which times follow."""
    for is_sample, group in groupby(lines, lambda it: it.get("gap") is False):
        if not is_sample:
            yield from map(_json, group)
            continue
        samples = list(group)
        first, last = samples[0]["time"], samples[-1]["time"]
        yield _json(samples[0])
        yield f"{len(samples)} samples, {first}–{last}, {_hash(_json(samples))}"


def _hash(content: str | bytes) -> str:
    data = content.encode() if isinstance(content, str) else content
    return hashlib.sha256(data).hexdigest()[:16]


def _json(value: object) -> str:
    return json.dumps(value, ensure_ascii=False, separators=(",", ":"))


def _text(*parts: Any) -> str:
    """Titles and lines in turn."""
    text = "".join(
        f"## {title}\n" + "".join(f"{str(line).rstrip()}\n" for line in lines)
        for title, lines in zip(parts[::2], parts[1::2], strict=True)
    )
    return text.replace(shipped().version, CATALOG)


RUNS = {"log": log, "watch": watch, "publish": publish, "dashboard": dashboard}
