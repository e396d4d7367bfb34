"""Instruments in a session, on simulated time: what they give, and that the unit never notices."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import mikas
from mikas.catalog import shipped
from mikas.errors import LinkLost, NoPortGiven, UsageError
from mikas.i18n import Text
from mikas.instruments import InstrumentValues, decoder_of, definition_named
from mikas.instruments.choosing import ChosenInstrument, chosen_instruments
from mikas.instruments.reading import InstrumentReader, InstrumentState
from mikas.instruments.session_instruments import SessionInstruments
from mikas.instruments.virtual_source import VirtualSource
from mikas.link.base import Chunk, Direction
from mikas.link.ports import Port
from mikas.recording.capture.instruments import (
    CONNECTED,
    loss,
)
from mikas.recording.capture.reader import Packet, Source
from mikas.recording.table.instrument_columns import InstrumentColumns, RawInstrument
from mikas.sampling.instrument_changes import InstrumentChanged
from unplugged_instruments import BOTH, CITY, Unplugged, drive_with_outages, prepare

CHANNELS = ("FREQ", "VALF")


def test_a_meter_and_a_receiver_agree_with_the_virtual_car(tmp_path: Path) -> None:
    path = tmp_path / "a.pcapng"
    with mikas.session(
        CITY, [*CHANNELS, "INJ"], record=path, duration=90, rate=5, instruments=BOTH
    ) as session:
        samples = list(session)
    assert [channel.name for channel in session.channels][-7:-5] == ["LAMBDA", "AFR"]
    burning = [it.values for it in samples[50:] if it.values["INJ"] > 1.0 and it.instruments]
    off = [abs(it["LAMBDA"] - it["VALF"]) for it in burning]
    assert np.median(off) < 0.03  # a step of the gauge is 0.007, the unit's counts what it meters
    speeds = [it.values.get("GPS_SPEED", np.nan) for it in samples]
    assert np.nanmax(speeds) > 25
    # The way by the positions is the way by the speeds.
    table = mikas.open(path, names=["GPS_LAT", "GPS_LON", "GPS_SPEED"]).to_pandas().dropna()
    north = np.diff(table["GPS_LAT"]) * 111_195
    east = np.diff(table["GPS_LON"]) * 111_195 * np.cos(np.radians(56.3))
    way = np.hypot(north, east).sum()
    seconds = np.diff(table.index.to_numpy())
    assert way == pytest.approx((table["GPS_SPEED"].to_numpy()[1:] / 3.6 * seconds).sum(), rel=0.1)


def test_one_that_is_unplugged_at_random_for_an_hour_costs_the_unit_nothing(
    tmp_path: Path,
) -> None:
    drive = drive_with_outages(tmp_path, lambda source, _, outages: Unplugged(source, outages))
    assert drive.meter.outages.count > 15
    frame = mikas.open(drive.path, names=["AFR", "LAMBDA", "GPS_SPEED"]).to_pandas()
    known = frame["AFR"].dropna()
    assert 0 < len(known) < len(frame)
    assert set(known) <= drive.whole
    # None is old.
    given = drive.meter.given
    sent = np.array([it.time for it in given if it.data.endswith(b"\r\n")])
    rows = known.index.to_numpy() + unit_begin(drive.path)
    ages = rows - sent[np.searchsorted(sent, rows + 1e-6) - 1]
    assert ages.max() <= 1.0 + 1e-3


def unit_begin(path: Path) -> float:
    (first, *_) = mikas.open(path).rows()
    return float(first.times[0])


class Scripted:
    """A source that gives what a script says at each poll."""

    def __init__(self, script: list[list[Chunk]]) -> None:
        self._script: Iterator[list[Chunk]] = iter(script)

    def open(self) -> None: ...

    def read(self) -> list[Chunk]:
        return next(self._script, [])

    def reset(self) -> None: ...

    def close(self) -> None: ...


def test_a_wrong_speed_is_silence_with_its_reason(tmp_path: Path) -> None:
    with prepare(tmp_path / "a.pcapng", ("aem=sim:",), duration=10) as session:
        assert session.instruments is not None
        noise = [[Chunk(b"\n\xfe\x80x\n", 0.0)]] * 20
        session.instruments = SessionInstruments(
            session.instruments.chosen,
            session.acquisition.port,
            session.recorder,
            (CONNECTED, loss),
            sources=[Scripted(noise)],
        )
        found = [it for it in session.events() if isinstance(it, InstrumentChanged)]
    assert [it.state for it in found] == [InstrumentState.CONNECTED, InstrumentState.SILENT]
    assert "baud" in found[-1].text.en
    assert "not understood" in found[-1].text.en


@pytest.mark.parametrize(
    ("texts", "problem"),
    [
        (["aem"], "Write NAME=URL"),
        (["=x"], "Write NAME=URL"),
        (["aem="], "Write NAME=URL"),
        (["ame=/dev/x"], "Did you mean aem"),
        (["aem=/dev/a", "14point7=/dev/b"], "label one of them"),
        (["a1:aem=/dev/a", "a1:innovate=/dev/b"], "label one of them"),
        (["aem=gpsd:localhost"], "gpsd serves GPS receivers"),
        (["aem=nosuch://x"], "nosuch"),
        (["aem=/dev/a", "left:innovate=/dev/a?baud=9600"], "left:innovate: aem is at the port"),
        (["aem=socket://Box:1", "left:aem=socket:box:1"], "a port of its own"),
        (["gpsd=/dev/a"], "gpsd=gpsd:localhost:2947"),
        (["gpsd=sim:"], "no virtual “gpsd”"),
        (["aem=sim:?scenario=city"], "no options"),
        (["aem=socket://box:1?baud=0"], "allowed: 50"),
        (["aem=COM4?baud=99999999"], "allowed: 50"),
        (["aem=COM4?baud=fast"], "allowed: 50"),
    ],
)
def test_what_can_not_be_is_refused(texts: list[str], problem: str) -> None:
    with pytest.raises(UsageError, match=problem):
        chosen_instruments(texts, shipped())


def test_a_file_named_as_a_known_instrument_is_refused(tmp_path: Path) -> None:
    """A recording has the name only, and would be read by the other definition."""
    mine = tmp_path / "aem.toml"
    mine.write_text('text = "Mine"\ndecoder = "line"\npatterns = ["X {AFR}"]\n', "utf-8")
    with pytest.raises(UsageError, match="my-aem"):
        chosen_instruments([f"left:{mine}=COM4"], shipped())
    assert definition_named(str(mine)).patterns == ("X {AFR}",)  # to decode a recording again


def test_the_port_of_the_unit_is_no_instruments(tmp_path: Path) -> None:
    """Its bytes would be taken for the unit's, and after a loss it would take the unit's port."""
    link = tmp_path / "by-id"
    link.symlink_to("/dev/null")
    for unit, meter in (
        ("/dev/ttyUSB0", "/dev/ttyUSB0?baud=19200"),
        ("/dev/null", str(link)),
        ("socket://box:4001", "socket:BOX:4001?baud=9600"),
    ):
        with pytest.raises(UsageError, match="the unit itself is at"):
            mikas.session(unit, ["FREQ"], instruments=f"aem={meter}")
    mikas.session("socket://box:4001", ["FREQ"], instruments="aem=socket://box:4002").close()
    both = ["nmea=gpsd:", "rear:nmea=gpsd:", "aem=sim:", "left:aem=sim:"]
    assert len(chosen_instruments(both, shipped())) == 4  # a gpsd and a car have room for all


def test_an_adapter_at_which_an_instrument_is_is_not_taken_for_the_units(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def adapter(url: str) -> Port:
        return Port(url, "FT232R", chip="FT232R", likely=True)

    ports = [adapter("/dev/ttyUSB0"), adapter("/dev/ttyUSB1")]
    monkeypatch.setattr("mikas.live.starting.find_ports", lambda: ports)
    with mikas.session(channels=["FREQ"], instruments="aem=/dev/ttyUSB0?baud=9600") as session:
        assert session.acquisition.port.url == "/dev/ttyUSB1"
    del ports[1]
    with pytest.raises(NoPortGiven):
        mikas.session(channels=["FREQ"], instruments="aem=/dev/ttyUSB0")


def test_labels_files_and_gpsd_are_understood(tmp_path: Path) -> None:
    mine = tmp_path / "my-meter.toml"
    mine.write_text('text = "Mine"\ndecoder = "line"\npatterns = ["{AFR}"]\n', encoding="utf-8")
    found = chosen_instruments(
        ["left:aem=/dev/a?baud=19200", f"rear:{mine}=COM4", "nmea=gpsd:"], shipped()
    )
    assert [(it.label, it.definition.name) for it in found] == [
        ("left", "aem"), ("rear", "my-meter"), ("", "gpsd")
    ]  # fmt: skip
    assert [it.name for it in found[0].channels] == ["LAMBDA_LEFT", "AFR_LEFT"]
    assert found[0].title == "left:aem"


def test_a_virtual_instrument_needs_a_virtual_car() -> None:
    from mikas.link.reconnecting import ReconnectingPort

    chosen = ChosenInstrument(definition_named("aem"), "sim:")
    with pytest.raises(LinkLost, match="no virtual car"):
        VirtualSource(chosen, ReconnectingPort("sim:")).open()


@pytest.mark.parametrize("name", ["aem", "14point7", "innovate", "nmea"])
def test_each_virtual_instrument_is_understood_by_its_own_definition(name: str) -> None:
    from mikas.virtual.build import build_bus
    from mikas.virtual.cars import EngineCar
    from mikas.virtual.instruments import VirtualInstrument

    car = build_bus({"scenario": "city"}).ecu.responder.car
    assert isinstance(car, EngineCar)
    instrument = VirtualInstrument(name, car, 0.0)
    wire = b"".join(message for _, message in instrument.sent(60.0))
    decoder = decoder_of(definition_named(name))
    if name != "innovate":  # the first line of text may be half of one
        decoder.feed(b"\n")
    events = decoder.feed(wire)
    assert len(events) >= 60
    assert all(isinstance(event, InstrumentValues) for event in events)


METER = Source(0, "/dev/x", "aem", 9600, instrument=True)


class Noted:
    """Keeps what a recorder gets."""

    def __init__(self) -> None:
        self.packets: list[Packet] = []

    def record_instrument(self, number: int, data: bytes, time: float, comment: str = "") -> None:
        self.packets.append(Packet(Direction.RECEIVED, data, time, 0, comment, METER))


def test_a_live_row_has_the_value_that_the_recording_has() -> None:
    """That before the row, not one that has come since; none from before a loss."""
    (aem,) = chosen_instruments(["aem=/dev/x"], shipped())
    lost = [Chunk(b"", -1.0)]  # stands for a loss
    script: list[list[Chunk]] = [
        [],
        [Chunk(b"\r\n1.000\r\n", 10.0)],
        [Chunk(b"1.100\r\n", 10.4), Chunk(b"1.200\r\n", 10.5)],
        [Chunk(b"1.3", 10.7)],
        lost,
        [],
        [Chunk(b"\r\n1.400\r\n", 13.0)],
    ]
    now, noted = 9.0, Noted()

    class Pulled(Scripted):
        def read(self) -> list[Chunk]:
            found = super().read()
            if found is lost:
                raise LinkLost(url="/dev/x", problem=Text("out", "отключён"))
            return found

    reader = InstrumentReader(
        0, aem, Pulled(script), noted, clock=lambda: now, report=lambda _: None,
        comments=(CONNECTED, loss),
    )  # fmt: skip
    live: dict[float, float] = {}
    for at, rows in (
        (9.0, [9.5]),
        (10.0, [9.9, 10.0]),
        (10.6, [10.1, 10.39, 10.45, 10.55]),
        (10.7, [10.65]),
        (10.8, [10.75, 10.9]),
        (12.5, [12.5]),
        (13.1, [10.78, 12.9, 13.05, 13.99, 14.01]),
    ):
        now = at
        reader.poll()
        for row in rows:
            live[row] = getattr(reader.fresh(row).get("LAMBDA"), "value", np.nan)
    raw = RawInstrument(METER)
    for packet in noted.packets:
        raw.add(packet)
    samples = InstrumentColumns([raw], shipped()).samples(0, "LAMBDA")
    assert samples is not None
    np.testing.assert_array_equal(samples.at(np.array([*live])), [*live.values()])
    assert [live[row] for row in (10.1, 10.39, 10.45, 10.75)] == [1.0, 1.0, 1.1, 1.2]
    assert np.isnan([live[row] for row in (9.9, 10.9, 12.9, 14.01)]).all()


def test_of_a_very_quick_instrument_a_row_has_a_value_all_the_same() -> None:
    """More has come since the row than is kept: the nearest one, rather than none."""
    (aem,) = chosen_instruments(["aem=/dev/x?baud=4000000"], shipped())
    chunks = [Chunk(f"{1 + at / 1e4:.4f}\r\n".encode(), 10 + at / 1e4) for at in range(5000)]
    reader = InstrumentReader(
        0, aem, Scripted([chunks]), Noted(), clock=lambda: 10.5, report=lambda _: None,
        comments=(CONNECTED, loss),
    )  # fmt: skip
    reader.poll()
    assert reader.fresh(10.2)["LAMBDA"].value == pytest.approx(1.45, abs=0.01)
    assert reader.fresh(10.49)["LAMBDA"].value == pytest.approx(1.49, abs=0.001)
    assert "LAMBDA" not in reader.fresh(12.0)
