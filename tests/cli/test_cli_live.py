"""The live table: what fits which terminal, and what it says of the wire."""

from __future__ import annotations

import io

import pytest

from mikas.cli import layout, words
from mikas.cli.live import LiveTable, sparkline
from mikas.client import Sample, connect
from mikas.errors import NoResponse

rich_console = pytest.importorskip("rich.console")


@pytest.fixture
def ecu(tmp_path):
    with connect("sim:?clock=simulated", state=tmp_path, journal=tmp_path / "journal") as connected:
        yield connected
    words.choose("en")


def console(width: int, height: int):
    return rich_console.Console(
        file=io.StringIO(), width=width, height=height, force_terminal=True, color_system=None
    )


def drawn(ecu, width: int, height: int, *samples: Sample) -> list[str]:
    wanted = ecu.catalog.parameters[:23]
    screen = console(width, height)
    table = LiveTable(ecu, wanted, screen)
    for sample in samples:
        table.show(sample)
    plain = console(width, height)
    plain.print(table.drawing())
    return plain.file.getvalue().splitlines()


def sample_of(ecu) -> Sample:
    return next(iter(ecu.watch(count=1)))


SIZES = [(80, 24), (80, 25), (100, 30), (120, 40), (200, 60), (132, 24), (60, 24), (45, 20)]


@pytest.mark.parametrize("language", ["en", "ru"])
@pytest.mark.parametrize(("width", "height"), SIZES)
def test_it_fits_and_nothing_is_left_out_silently(ecu, width, height, language):
    words.choose(language)
    lines = drawn(ecu, width, height, sample_of(ecu))
    assert len(lines) <= height
    assert max(map(len, lines)) <= width
    text = "\n".join(lines)
    for parameter in ecu.catalog.parameters[:23]:
        assert parameter.name in text
    assert "No room for" not in text or width < 60


def test_what_has_no_room_is_named(ecu):
    lines = drawn(ecu, 60, 8, sample_of(ecu))
    assert len(lines) <= 8
    assert lines[-1].startswith("No room for ")
    shown = "\n".join(lines[:-1])
    for name in lines[-1].removeprefix("No room for ").replace("…", "").split():
        assert f"{name} " not in shown


@pytest.mark.parametrize(("width", "height"), [(1, 1), (10, 3), (20, 5), (300, 2)])
def test_an_absurd_terminal_is_no_crash(ecu, width, height):
    drawn(ecu, width, height, sample_of(ecu))


def test_columns_come_with_the_width(ecu):
    sample = sample_of(ecu)

    def heads(width):
        return drawn(ecu, width, 60, sample)[1].split()

    assert heads(40)[:3] == ["name", "value", "unit"]
    assert "meaning" in heads(80)
    assert {"min", "max", "meaning"} <= set(heads(100))
    assert "lately" in heads(140)


def test_the_first_line_tells_the_state(ecu):
    assert "waiting for the first answer" in drawn(ecu, 80, 24)[0]
    assert "ECU answers · Mikas 7.1" in drawn(ecu, 80, 24, sample_of(ecu))[0]
    gap = Sample(ecu.tester.link.now(), reason=NoResponse(seconds=0.5))
    lines = drawn(ecu, 80, 24, sample_of(ecu), gap)
    assert lines[0].startswith("○ The ECU did not answer within 0.5 s")
    twat = next(line for line in lines if "TWAT " in line)
    assert "–" in twat  # never the last number


def test_the_last_state_is_left_on_the_screen(ecu):
    screen = console(80, 24)
    table = LiveTable(ecu, ecu.catalog.parameters[:23], screen)
    with table:
        table.show(sample_of(ecu))
    written = screen.file.getvalue()
    before, _, after = written.rpartition("\x1b[?1049l")  # back from the other screen
    assert "\x1b[?1049h" in before
    assert "\x1b[?25h" in written  # the cursor is seen again
    assert "TWATI" in after
    assert "Ctrl-C" not in after


def test_the_small_curve():
    assert sparkline([]) == ""
    assert sparkline([1.0]) == ""
    assert sparkline([0, 1, 2, 3, 4, 5, 6, 7]) == "▁▂▃▄▅▆▇█"
    assert sparkline([5, 5, 5]) == "▁▁▁"
    assert len(sparkline(range(60))) == 20


def test_rows_of_nothing():
    screen = console(80, 24)
    screen.print(layout.draw("state", "green", [], 80, 24))
    assert "state" in screen.file.getvalue()
