"""The hour with a λ meter that is unplugged at random, its bytes through a real pty."""

from __future__ import annotations

import os
import pty
import tty
from pathlib import Path
from typing import cast

import pytest

import mikas
from mikas.instruments import sources
from mikas.instruments.choosing import ChosenInstrument
from mikas.instruments.sources import InstrumentSource, LinkSource
from mikas.link import Link, open_link
from mikas.link.base import Chunk, LinkWrapper
from mikas.link.suspension import SuspensionGuard
from unplugged_instruments import HALF, Outages, Unpluggable, drive_with_outages

pytestmark = pytest.mark.posix

UNTIL_NOTICED = 1000  # reads; the simulated hour does not go on meanwhile


def at_any_pace(url: str) -> Link:
    """Open the port without the guard of its reader's pace: how long a busy machine takes for the
    simulated hour between two reads says nothing of the bytes.
    """
    guard = cast("LinkWrapper", open_link(url)).link
    assert isinstance(guard, SuspensionGuard)
    return guard.link


class Wired:
    """What `inner` sends goes through a pty, whose name is `port`, and is read as a session reads a
    port. The pty is closed when the instrument is pulled out, and another one has the name then.
    """

    def __init__(
        self, inner: InstrumentSource, chosen: ChosenInstrument, outages: Outages, port: Path
    ) -> None:
        self._inner, self._port, self.outages = inner, port, outages
        own = ChosenInstrument(chosen.definition, str(port))
        self._link = LinkSource(own, outages.now, at_any_pace)
        self._master: int | None = None
        self.given: list[Chunk] = []
        self.sent = b""

    def open(self) -> None:
        if self._master is None and not self.outages.out:
            self._master, slave = pty.openpty()
            tty.setraw(slave)
            self._port.symlink_to(os.ttyname(slave))
            self._link.open()
            os.close(slave)
            self._inner.open()
        else:
            self._link.open()

    def read(self) -> list[Chunk]:
        if self.outages.begins():
            half = self._through(HALF) if self.outages.in_a_line() else []
            self._pull()
            if half:
                return half
        if self._master is None:
            for _ in range(UNTIL_NOTICED):  # a busy computer says late that the pty is closed
                self._link.read()
            raise AssertionError("the closed pty was not noticed")
        return self._through(b"".join(it.data for it in self._inner.read()))

    def _through(self, data: bytes) -> list[Chunk]:
        assert self._master is not None
        if not data:
            return []
        os.write(self._master, data)
        self.sent += data
        read: list[Chunk] = []
        while sum(len(it.data) for it in read) < len(data):
            read += self._link.read()
        chunk = Chunk(b"".join(it.data for it in read), read[-1].time)
        self.given.append(chunk)
        return [chunk]

    def _pull(self) -> None:
        if self._master is not None:
            self._port.unlink()
            os.close(self._master)
            self._master = None

    def reset(self) -> None:
        self._link.reset()
        self._inner.reset()

    def close(self) -> None:
        self._link.close()
        self._pull()


def test_an_hour_over_a_pty_that_is_closed_at_random(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sources, "_GATHER", 0.0)  # s of the wall; the hour is a simulated one

    def wired(source: InstrumentSource, chosen: ChosenInstrument, outages: Outages) -> Unpluggable:
        return Wired(source, chosen, outages, tmp_path / "ttyMeter")

    drive = drive_with_outages(tmp_path, wired)
    assert drive.meter.outages.count > 15
    assert isinstance(drive.meter, Wired)
    assert b"".join(it.data for it in drive.meter.given) == drive.meter.sent
    values = mikas.open(drive.path, names=["AFR"]).to_pandas()["AFR"].dropna()
    assert len(values) > 1000
    assert set(values) <= drive.whole
