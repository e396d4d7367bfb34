"""A drive with a unit, a λ meter and a GPS on ptys, recorded by `mikas log` and opened elsewhere.

What each of the three sent, and when, is written down here, at the other end of the wires; pandas,
asammdf and the readers of MegaLogViewer's logs must find the same numbers at those times.
"""

from __future__ import annotations

import asyncio
import json
import os
import pty
import subprocess
import sys
import threading
import time
import tty
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from functools import reduce
from itertools import count
from operator import xor
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from mikas.catalog import shipped
from mikas.recording.capture.instruments import instrument_packets, label_and_name
from mikas.virtual.build import build_bus
from mikas.virtual.serve import PtyPort, run
from viewer_logs import read_mlg, read_msl

pytestmark = [pytest.mark.realtime, pytest.mark.posix]
PROGRAM = [sys.executable, "-c", "from mikas.cli.main import main; main()"]
LENGTH = 12.0  # s of the recording
SILENT = (2.0, 7.0)  # s, in which the meter sends nothing
LATE = 2.0  # s that a busy machine may bring a line late
EARLY = 0.1  # s by which a reading may seem to be before its bytes, which a pty brings at once
UNITS = {
    "FREQ": "rpm", "UACC": "V", "LAMBDA": "λ", "AFR": "", "GPS_SPEED": "km/h", "GPS_LAT": "°",
    "GPS_LON": "°", "GPS_ALT": "m", "GPS_COURSE": "°",
}  # fmt: skip
VIEWERS = {"FREQ": "RPM", "UACC": "Batt V"}
"""What MegaLogViewer calls them."""
HELD = {"LAMBDA": 1.0, "AFR": 1.0, "GPS_SPEED": 2.5, "GPS_LAT": 2.5, "GPS_LON": 2.5}  # s
KNOT = 1.852  # km/h


@dataclass
class Wires:
    """What went out on the three wires: the values, and when those of the instruments did."""

    began: float | None = None
    """When the unit was sampled."""
    unit: list[float] = field(default_factory=list)
    meter: list[tuple[float, float]] = field(default_factory=list)
    receiver: list[tuple[float, dict[str, float]]] = field(default_factory=list)
    said: dict[str, bytes] = field(default_factory=lambda: {"aem": b"", "nmea": b""})
    """All bytes of the instruments."""

    def sent(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """The times and the values of an instrument's channel."""
        if name in ("AFR", "LAMBDA"):
            pairs = [(at, afr if name == "AFR" else afr / 14.7) for at, afr in self.meter]
        else:
            pairs = [(at, values[name]) for at, values in self.receiver]
        times, values = zip(*pairs, strict=True)
        return np.array(times), np.array(values)


@contextmanager
def unit(wires: Wires) -> Iterator[str]:
    """A unit whose speed is another one in each response; yields its port."""
    bus = build_bus({"scenario": "warm-idle"}, start=time.monotonic())
    car, code = bus.ecu.responder.car, shipped().parameter("FREQ").code
    usual, number = car.raw, count()

    def raw(asked: int, now: float) -> bytes:
        if asked != code:
            return usual(asked, now)
        step = 20 + next(number) % 120
        wires.unit.append(step * 40.0)
        if len(wires.unit) == 10:
            wires.began = time.time()
        return bytes([step])

    car.raw = raw
    ready, made = threading.Event(), []

    async def serve() -> None:
        port, ended = PtyPort(bus, time.monotonic), asyncio.Event()
        made.append((port.url, asyncio.get_running_loop(), ended))
        ready.set()
        await ended.wait()
        port.close()

    thread = threading.Thread(target=lambda: run(serve()))
    thread.start()
    assert ready.wait(30)
    ((url, loop, ended),) = made
    try:
        yield url
    finally:
        loop.call_soon_threadsafe(ended.set)
        thread.join()


@contextmanager
def instrument(every: float, line: Callable[[], bytes]) -> Iterator[str]:
    """An instrument that sends what `line()` gives, `every` so many seconds; yields its port."""
    master, slave = pty.openpty()
    tty.setraw(slave)
    ended = threading.Event()

    def send() -> None:
        while not ended.wait(every):
            os.write(master, line())

    thread = threading.Thread(target=send)
    thread.start()
    try:
        yield os.ttyname(slave)
    finally:
        ended.set()
        thread.join()
        os.close(slave)
        os.close(master)


def meter(wires: Wires) -> Callable[[], bytes]:
    """Another mixture in each line, two decimals; a while without any."""
    number = count()

    def line() -> bytes:
        now = time.time()
        if wires.began is not None and SILENT[0] <= now - wires.began < SILENT[1]:
            return b""
        text = f"{10 + next(number) / 100:.2f}"
        wires.meter.append((now, float(text)))
        message = text.encode() + b"\r\n"
        wires.said["aem"] += message
        return message

    return line


def receiver(wires: Wires) -> Callable[[], bytes]:
    """Another place and speed in each sentence."""
    number = count()

    def sentence() -> bytes:
        n = next(number)
        knots, north, east = n / 10, 45 + n / 1000, 37.2 + n / 500  # minutes
        values = {"GPS_SPEED": knots * KNOT, "GPS_LAT": 55 + north / 60, "GPS_LON": 37 + east / 60}
        wires.receiver.append((time.time(), values))
        body = (
            f"GPRMC,120000.00,A,55{north:07.4f},N,037{east:07.4f},E,{knots:.1f},90.0,011226,,,A"
        ).encode()
        message = b"$%b*%02X\r\n" % (body, reduce(xor, body))
        wires.said["nmea"] += message
        return message

    return sentence


@dataclass
class Opened:
    """A recording as another program has it: times from the first row."""

    units: dict[str, str]
    times: np.ndarray
    values: dict[str, np.ndarray]


def csv(path: Path) -> Opened:
    frame = pd.read_csv(path)
    titles = {title.split()[0]: title for title in frame.columns[1:]}
    units = {name: title[title.rindex("(") + 1 : -1] if title.endswith(")") else ""
             for name, title in titles.items()}  # fmt: skip
    values = {name: frame[title].to_numpy(float) for name, title in titles.items()}
    assert frame.columns[0] == "Time (msec)"
    return Opened(units, frame["Time (msec)"].to_numpy(float) / 1000, values)


def parquet(path: Path) -> Opened:
    from pyarrow.parquet import read_schema

    frame = pd.read_parquet(path)
    about = json.loads(read_schema(path).metadata[b"mikas"])
    units = {name: each["unit"] for name, each in about["channels"].items()}
    times = frame.pop("time") if "time" in frame else frame.index
    return Opened(units, np.array(times, float), {it: frame[it].to_numpy(float) for it in frame})


def mdf(path: Path) -> Opened:
    from asammdf import MDF  # here: its import takes 2 s

    with MDF(path) as file:
        found = {each.name: each for each in file.iter_channels()}
        (times,) = {tuple(each.timestamps) for each in found.values()}
        units = {name: each.unit for name, each in found.items()}
        values = {name: each.samples.astype(float) for name, each in found.items()}
        return Opened(units, np.array(times), values)


def mlg(path: Path) -> Opened:
    log = read_mlg(path.read_bytes())
    time, *columns = np.array(log.values).T
    names = log.names[1:]
    return Opened(
        dict(zip(names, log.units[1:], strict=True)), time, dict(zip(names, columns, strict=True))
    )


def msl(path: Path) -> Opened:
    _, _, names, units, rows = read_msl(path)
    time, *columns = np.array(rows, float).T
    return Opened(
        dict(zip(names[1:], units[1:], strict=True)),
        time,
        dict(zip(names[1:], columns, strict=True)),
    )


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> tuple[Wires, Path]:
    """A drive as a person records it, by the program as a process."""
    folder, wires = tmp_path_factory.mktemp("drive"), Wires()
    with ExitStack() as stack:
        port = stack.enter_context(unit(wires))
        aem = stack.enter_context(instrument(0.05, meter(wires)))
        nmea = stack.enter_context(instrument(0.25, receiver(wires)))
        command = [
            *PROGRAM, "log", "-o", "drive.pcapng", "FREQ", "UACC", "--port", port,
            "--instrument", f"aem={aem}", "--instrument", f"nmea={nmea}",
            "--rate", "20", "--duration", str(LENGTH),
        ]  # fmt: skip
        done = subprocess.run(
            command, cwd=folder, env=os.environ | {"HOME": str(folder), "MIKAS_LANG": "en"},
            capture_output=True, text=True, timeout=120, check=False,
        )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return wires, folder / "drive.pcapng"


def exported(recording: Path, suffix: str) -> Path:
    """Export it, as a process does."""
    out = recording.with_suffix(suffix)
    if not out.exists():
        command = [*PROGRAM, "export", str(recording), "-o", str(out)]
        subprocess.run(command, env=os.environ, capture_output=True, timeout=120, check=True)
    return out


@pytest.fixture(scope="module")
def exact(drive: tuple[Wires, Path]) -> Opened:
    """The drive in pandas, from Parquet."""
    return parquet(exported(drive[1], ".parquet"))


@pytest.fixture(scope="module")
def began(drive: tuple[Wires, Path]) -> float:
    """The UNIX time of the first row, from the MDF4 file."""
    from asammdf import MDF  # here: its import takes 2 s

    with MDF(exported(drive[1], ".mf4")) as file:
        return float(file.start_time.timestamp())


def test_the_units_values_are_those_that_it_sent_in_their_order(
    drive: tuple[Wires, Path], exact: Opened
) -> None:
    wires, _ = drive
    found = exact.values["FREQ"]
    found = found[np.isfinite(found)]
    assert len(found) > 5 * LENGTH
    rest = iter(wires.unit)
    assert all(value in rest for value in found)  # each after the one before


@pytest.mark.parametrize("name", ["aem", "nmea"])
def test_no_byte_of_an_instrument_is_lost_or_another_ones(
    drive: tuple[Wires, Path], name: str
) -> None:
    wires, path = drive
    own = [it for it in instrument_packets(path) if label_and_name(it.source) == ("", name)]
    recorded = b"".join(it.data for it in own)
    assert recorded in wires.said[name]
    assert recorded.count(b"\n") > LENGTH * 2


@pytest.mark.parametrize("name", HELD)
def test_an_instruments_values_stand_where_they_were_sent(
    drive: tuple[Wires, Path], exact: Opened, began: float, name: str
) -> None:
    times, values = drive[0].sent(name)
    rows, column = exact.times + began, exact.values[name]
    known = np.flatnonzero(np.isfinite(column))
    assert len(known) > 0.3 * len(rows)
    numbers = np.abs(values[None, :] - column[known, None]).argmin(axis=1)
    np.testing.assert_allclose(column[known], values[numbers], rtol=0, atol=2e-7)
    assert (np.diff(numbers) >= 0).all()
    ages = rows[known] - times[numbers]
    assert ages.min() > -EARLY
    assert ages.max() < HELD[name] + LATE
    last = np.searchsorted(times, rows[known] - LATE, "right") - 1
    assert (numbers >= last).all()  # no row has a value with a later one before it


def test_a_value_is_missing_where_it_is_stale_and_no_other_one_is(
    drive: tuple[Wires, Path], exact: Opened
) -> None:
    for name in ("LAMBDA", "AFR"):
        known = np.flatnonzero(np.isfinite(exact.values[name]))
        pauses = exact.times[known[1:] - 1] - exact.times[known[:-1]]
        longest = pauses.max()
        assert longest > SILENT[1] - SILENT[0] - HELD[name] - LATE
    first = np.isfinite(exact.values["GPS_LAT"]).argmax()
    assert np.isfinite(exact.values["GPS_LAT"][first:]).mean() > 0.9
    assert np.isnan(exact.values["GPS_ALT"]).all()  # RMC has none


@pytest.mark.parametrize(
    ("suffix", "opened", "digits"),
    [
        (".csv", csv, 1e-15), (".parquet", parquet, 1e-15), (".mf4", mdf, 1e-15),
        (".msl", msl, 1e-15), (".mlg", mlg, 1e-6),
    ],
)  # fmt: skip
def test_each_program_has_all_three_with_their_units_and_times(
    drive: tuple[Wires, Path],
    exact: Opened,
    suffix: str,
    opened: Callable[[Path], Opened],
    digits: float,
) -> None:
    found = opened(exported(drive[1], suffix))
    names = {
        name: VIEWERS.get(name, name) if suffix in (".msl", ".mlg") else name for name in UNITS
    }
    assert {name: found.units[shown] for name, shown in names.items()} == UNITS
    np.testing.assert_allclose(found.times, exact.times, rtol=0, atol=0.00051)
    for name, shown in names.items():
        np.testing.assert_allclose(found.values[shown], exact.values[name], rtol=digits, atol=0)
