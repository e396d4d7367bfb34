"""Instruments over real ptys and sockets, each on its thread, beside a unit in real time."""

from __future__ import annotations

import os
import pty
import socket
import threading
import tty
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from functools import reduce
from operator import xor
from pathlib import Path

import pytest

import mikas
from mikas.instruments.decoders.gpsd import WATCH
from mikas.instruments.reading import InstrumentState
from mikas.recording.capture.instruments import instrument_packets, loss_of
from mikas.sampling.events import Sampled
from mikas.sampling.instrument_changes import InstrumentChanged

pytestmark = [pytest.mark.realtime, pytest.mark.posix]
PATIENCE = 30.0  # s of the unit's time
RMC = b"GPRMC,1,A,5617.7900,N,04356.1660,E,20.0,84.4,230394,,,A"


class Pty:
    """A serial port that a test writes to."""

    def __init__(self) -> None:
        self.master, slave = pty.openpty()
        tty.setraw(slave)
        self.path = os.ttyname(slave)
        self._slave: int | None = slave

    def write(self, data: bytes) -> None:
        os.write(self.master, data)

    def close(self) -> None:
        if self._slave is not None:
            os.close(self._slave)
            os.close(self.master)
            self._slave = None


@contextmanager
def ptys(count: int) -> Iterator[list[Pty]]:
    found = [Pty() for _ in range(count)]
    try:
        yield found
    finally:
        for each in found:
            each.close()


def until(session: mikas.Session, wanted: Callable[[Sampled], bool]) -> Sampled:
    """Return the first sample that is wanted; the unit's clock limits the wait."""
    first: float | None = None
    for sample in session:
        first = sample.time if first is None else first
        if wanted(sample):
            return sample
        assert sample.time - first < PATIENCE
    raise AssertionError("the session ended")


def test_a_meter_and_a_receiver_on_ptys_and_one_is_pulled_out(tmp_path: Path) -> None:
    path = tmp_path / "a.pcapng"
    sentence = b"$" + RMC + b"*%02X\r\n" % reduce(xor, RMC, 0)
    with ptys(2) as (meter, receiver):
        instruments = [f"aem={meter.path}", f"nmea={receiver.path}"]
        session = mikas.session(
            "sim:?seed=1", ["FREQ"], record=path, instruments=instruments, rate=50
        )
        changes: list[InstrumentChanged] = []
        session.on(InstrumentChanged, changes.append)
        with session:
            connected = (InstrumentState.CONNECTED,) * 2
            until(session, lambda _: tuple(it.state for it in changes) == connected)
            meter.write(b"\r\n14.")
            meter.write(b"7\r\n")
            receiver.write(sentence)
            both = until(session, lambda it: {"AFR", "GPS_SPEED"} <= {*it.values})
            assert both.values["AFR"] == 14.7
            assert both.values["GPS_SPEED"] == pytest.approx(37.04)
            assert abs(both.instruments["AFR"].time - both.time) < 1.0
            said = both.instruments["AFR"].time
            until(session, lambda it: it.time > said + 0.1)
            meter.close()
            lost = until(session, lambda _: changes[-1].state is InstrumentState.LOST)
            assert changes[-1].name == "aem"
            receiver.write(sentence)
            later = until(session, lambda it: it.time > lost.time + 0.5)
            assert "AFR" not in later.values
            assert later.values["GPS_SPEED"] == pytest.approx(37.04)
    packets = list(instrument_packets(path))
    assert b"".join(it.data for it in packets if "aem" in it.source.description) == b"\r\n14.7\r\n"
    assert sum(loss_of(it) is not None for it in packets) == 1
    table = mikas.open(path, names=["AFR", "GPS_LAT"]).to_pandas()
    assert set(table["AFR"].dropna()) == {14.7}
    assert table["GPS_LAT"].dropna().iloc[0] == pytest.approx(56.2965)


def test_gpsd_is_asked_for_json_and_found_again(tmp_path: Path) -> None:
    asked: list[bytes] = []
    report = b'{"class":"TPV","mode":3,"lat":56.2965,"lon":43.936,"speed":10.0}\r\n'
    ended = threading.Event()

    def serve(server: socket.socket) -> None:
        for _ in range(2):  # the first connection ends after its report
            connection, _ = server.accept()
            with closing(connection):
                connection.sendall(b'{"class":"VERSION","release":"3.25"}\r\n')
                asked.append(connection.recv(len(WATCH)))
                connection.sendall(report)
                if len(asked) == 2:
                    ended.wait(PATIENCE)

    with closing(socket.create_server(("127.0.0.1", 0))) as server:
        thread = threading.Thread(target=serve, args=(server,))
        thread.start()
        port = server.getsockname()[1]
        changes: list[InstrumentChanged] = []
        with mikas.session(
            "sim:", ["FREQ"], instruments=f"nmea=gpsd:127.0.0.1:{port}", rate=50
        ) as session:
            session.on(InstrumentChanged, changes.append)
            until(session, lambda _: InstrumentState.LOST in [it.state for it in changes])
            sample = until(session, lambda it: "GPS_SPEED" in it.values and len(asked) == 2)
            assert sample.values["GPS_SPEED"] == 36.0
            ended.set()
        thread.join(PATIENCE)
    assert asked == [WATCH] * 2
