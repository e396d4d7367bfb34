"""The live table without values and without events: its values age by the clock alone."""

from __future__ import annotations

import io
from types import SimpleNamespace

import pytest

from mikas.catalog import load
from mikas.cli.language import set_language
from mikas.cli.render.live_table import LiveTable
from mikas.cli.render.output import Output
from mikas.client.parameters.readings import decode
from mikas.errors import NoResponse
from mikas.sampling.events import CycleFailed, Sampled

rich_console = pytest.importorskip("rich.console")
CATALOG = load()


@pytest.fixture(autouse=True)
def in_english():
    yield
    set_language("en")


def console():
    return rich_console.Console(
        file=io.StringIO(), width=100, height=24, force_terminal=True, color_system="standard"
    )


class Drawn:
    """A table on a clock that stands until it is moved; samples come each `step` seconds."""

    def __init__(self, step: float, *names: str) -> None:
        self.now = 100.0
        self.step = step
        self.channels = [CATALOG.parameter(name) for name in names]
        self.screen = console()
        acquisition = SimpleNamespace(channels=self.channels, method="stream")
        model = CATALOG.model(0x0A).text
        session = SimpleNamespace(
            acquisition=acquisition, channels=acquisition.channels, model=model, errors=3
        )
        self.table = LiveTable(session, Output(), self.screen, lambda: self.now)

    def sample(self, *names: str) -> None:
        fresh = {
            name: decode(CATALOG.parameter(name), b"\x7d", self.now, "corrected") for name in names
        }
        self.table.add_event(Sampled(self.now, fresh, {}))

    def run(self, count: int, *names: str) -> None:
        for _ in range(count):
            self.now += self.step
            self.sample(*names)

    def after(self, seconds: float) -> tuple[str, str]:
        """The first line, and TWAT's, `seconds` after now."""
        self.now += seconds
        plain = console()
        plain.print(self.table.drawing())
        lines = plain.file.getvalue().splitlines()
        return lines[0], next(line for line in lines if "TWAT" in line)


def test_values_fade_and_go_without_an_event_of_silence():
    it = Drawn(0.01, "TWAT")
    it.run(30, "TWAT")
    first, row = it.after(0.9)
    assert "● sampling" in first
    assert "85" in row
    assert "\x1b[2m" not in row
    first, row = it.after(0.3)
    assert "○ no data for 1 s · Mikas 7.1 · errors 3" in first
    assert "85 (1 s)" in row
    assert "\x1b[2m" in row
    first, row = it.after(1.0)
    assert "○ no data for 2 s" in first
    assert row.split()[:2] == ["TWAT", "–"]
    it.run(30, "TWAT")
    first, row = it.after(0.0)
    assert "● sampling" in first
    assert row.split()[:2] == ["TWAT", "85"]
    set_language("ru")
    assert "○ нет данных 3 с" in it.after(3.0)[0]


def test_what_comes_seldom_by_its_own_pace_is_no_silence():
    it = Drawn(5.0, "TWAT")
    it.sample("TWAT")
    assert "● sampling" in it.after(60)[0]  # its period is not known yet
    it = Drawn(5.0, "TWAT")
    it.run(3, "TWAT")
    assert "● sampling" in it.after(14)[0]
    first, row = it.after(2)
    assert "○ no data for 16 s" in first
    assert "85 (16 s)" in row


def test_a_silence_adds_to_the_age_of_a_slow_name():
    it = Drawn(0.5, "TWAT", "THR")
    it.sample("TWAT", "THR")
    it.run(8, "THR")
    assert "85 (4 s)" in it.after(0.0)[1]
    assert "85 (6 s)" in it.after(2.0)[1]


def test_how_long_a_gap_lasted_is_no_pace():
    it = Drawn(0.1, "TWAT")
    it.run(5, "TWAT")
    it.table.add_event(CycleFailed(it.now, NoResponse(seconds=0.5)))
    assert "The ECU did not answer" in it.after(60)[0]
    it.sample("TWAT")
    assert "○ no data for 1 s" in it.after(1.2)[0]


def test_what_is_left_on_the_screen_is_as_the_end_found_it():
    def left(kind):
        it = Drawn(0.1, "TWAT")
        it.run(5, "TWAT")
        it.now += 5
        it.table.__exit__(kind, None, None)
        return it.screen.file.getvalue()

    assert "● sampling" in left(None)
    assert "○ no data for 5 s" in left(KeyboardInterrupt)
