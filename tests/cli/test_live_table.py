"""The live table: what fits which terminal, and what it says of the wire."""

from __future__ import annotations

import io
from types import SimpleNamespace

import pytest

from mikas.catalog import AlarmLimits, load
from mikas.cli.language import set_language
from mikas.cli.render import table_layout
from mikas.cli.render.live_table import LiveTable, sparkline
from mikas.cli.render.output import Output
from mikas.client.parameters.derived import DerivedChannels
from mikas.client.parameters.readings import decode
from mikas.errors import EchoOnly, NoResponse
from mikas.sampling.alarms import Alarms
from mikas.sampling.events import CycleFailed, LineState, Sampled, StateChanged
from protocol_codes import with_limits

rich_console = pytest.importorskip("rich.console")
CATALOG = load()
CHANNELS = CATALOG.parameters[:23]


@pytest.fixture(autouse=True)
def in_english():
    yield
    set_language("en")


def session(channels=CHANNELS):
    """As much of a session as a table looks at."""
    acquisition = SimpleNamespace(channels=channels, method="stream")
    model = CATALOG.model(0x0A).text
    return SimpleNamespace(acquisition=acquisition, channels=channels, model=model, errors=3)


def console(width: int, height: int, **settings):
    return rich_console.Console(
        file=io.StringIO(), width=width, height=height, force_terminal=True,
        **{"color_system": None, **settings},
    )  # fmt: skip


def drawn(width: int, height: int, *events, channels=CHANNELS, notice="", **settings) -> list[str]:
    table = LiveTable(session(channels), Output(), console(width, height))
    for event in events:
        table.add_event(event)
    if notice:
        table.show_notice(notice)
    plain = console(width, height, **settings)
    plain.print(table.drawing())
    return plain.file.getvalue().splitlines()


def reading(name: str, raw: bytes, time: float = 1.0):
    return decode(CATALOG.parameter(name), raw, time, "corrected")


def sample_of(time: float = 1.0) -> Sampled:
    return Sampled(
        time, {p.name: decode(p, bytes(p.size), time, "corrected") for p in CHANNELS}, {}
    )


SIZES = [(80, 24), (80, 25), (100, 30), (120, 40), (200, 60), (132, 24), (60, 24), (45, 20)]


@pytest.mark.parametrize("language", ["en", "ru"])
@pytest.mark.parametrize(("width", "height"), SIZES)
def test_it_fits_and_nothing_is_left_out_silently(width, height, language):
    set_language(language)
    lines = drawn(width, height, sample_of())
    assert len(lines) <= height
    assert max(map(len, lines)) <= width
    text = "\n".join(lines)
    for parameter in CHANNELS:
        assert parameter.name in text
    assert "No room for" not in text or width < 60


def test_what_has_no_room_is_named():
    lines = drawn(60, 8, sample_of())
    assert len(lines) <= 8
    assert lines[-1].startswith("No room for ")
    shown = "\n".join(lines[:-1])
    for name in lines[-1].removeprefix("No room for ").replace("…", "").split():
        assert f"{name} " not in shown


@pytest.mark.parametrize(("width", "height"), [(1, 1), (10, 3), (20, 5), (300, 2)])
def test_an_absurd_terminal_is_no_crash(width, height):
    drawn(width, height, sample_of())


def test_columns_come_with_the_width():
    sample = sample_of()

    def heads(width):
        return drawn(width, 60, sample)[1].split()

    assert heads(40)[:3] == ["name", "value", "unit"]
    assert "meaning" in heads(80)
    assert {"min", "max", "meaning"} <= set(heads(100))
    assert "trend" in heads(140)


def test_the_first_line_shows_the_state():
    assert "waiting for the first response" in drawn(80, 24)[0]
    first = drawn(80, 24, sample_of())[0]
    assert first.startswith("● sampling · Mikas 7.1 · stream · ")
    assert "errors 3" in first


def test_a_lost_cycle_is_dashes_never_the_last_number():
    lines = drawn(80, 24, sample_of(), CycleFailed(2.0, NoResponse(seconds=0.5)))
    assert lines[0].startswith("○ The ECU did not answer within 0.5 s")
    assert "–" in next(line for line in lines if "TWAT " in line)
    assert "-40" not in "\n".join(line for line in lines if "TWAT " in line)


@pytest.mark.parametrize(
    ("state", "message"),
    [
        (LineState.NO_PORT, "○ no adapter · waiting"),
        (LineState.NO_ECHO, "○ no echo: no 12 V at the adapter, or the wrong port · waiting"),
        (LineState.ECHO_ONLY, "○ echo, but the ECU is silent: ignition off? · waiting"),
    ],
)
def test_a_broken_line_is_reported_in_words(state, message):
    lines = drawn(120, 24, sample_of(), StateChanged(2.0, state, EchoOnly()))
    assert lines[0].startswith(message)
    assert "–" in next(line for line in lines if "TWAT " in line)
    back = drawn(120, 24, StateChanged(2.0, state), StateChanged(3.0, LineState.SAMPLING))
    assert not back[0].startswith("○")


def test_a_value_of_an_earlier_cycle_is_faded_and_shows_its_age():
    channels = (CATALOG.parameter("TWAT"), CATALOG.parameter("FREQ"))
    first = Sampled(1.0, {"TWAT": reading("TWAT", b"\x7d")}, {})

    def later(time: float):
        lines = drawn(80, 24, first, Sampled(time, {"FREQ": reading("FREQ", b"\x15", time)}, {}),
                      channels=channels, color_system="standard")  # fmt: skip
        return next(line for line in lines if "TWAT" in line)

    assert "\x1b[2m" in later(1.5)
    assert "s)" not in later(1.5)
    assert "(4 s)" in later(5.0)
    assert "\x1b[2m" in later(5.0)


def test_a_derived_channel_is_a_row_like_any_other():
    made = DerivedChannels(CATALOG, ["DUTY"])
    readings = {"INJ": reading("INJ", bytes([0x10] * CATALOG.parameter("INJ").size)),
                "FREQ": reading("FREQ", b"\x15")}  # fmt: skip
    derived = made.update(readings, 1.0)
    lines = drawn(80, 24, Sampled(1.0, readings, {}, derived), channels=made.channels)
    row = next(line for line in lines if "DUTY" in line)
    assert f"{derived['DUTY'].value:.{derived['DUTY'].channel.decimals}f}" in row
    assert not any("INJ" in line for line in lines)  # an input is not shown


def test_an_alarm_has_a_colour_and_a_word():
    channels = (CATALOG.parameter("TWAT"),)
    hot = {"TWAT": reading("TWAT", b"\xaa")}
    alarms = Alarms(with_limits(CATALOG, TWAT=AlarmLimits(warning_high=100, danger_high=110)))
    raised = alarms.update(hot, 1.0)
    lines = drawn(80, 24, Sampled(1.0, hot, {}), *raised, channels=channels,
                  color_system="standard")  # fmt: skip
    assert "▲ TWAT: DANGER" in lines[1]
    assert "\x1b[1;37;41m" in next(line for line in lines if "Coolant" in line)
    cold = {"TWAT": reading("TWAT", b"\x50", 2.0)}
    over = alarms.update(cold, 2.0)
    lines = drawn(80, 24, Sampled(2.0, cold, {}), *raised, *over, channels=channels)
    assert not any("DANGER" in line for line in lines)


def test_the_latest_notice_stands_in_the_last_line():
    lines = drawn(80, 24, sample_of(), channels=CHANNELS[:3], notice="The unit refuses X.")
    assert lines[-1].startswith("The unit refuses X. Ctrl-C")


def test_the_last_state_is_left_on_the_screen(capsys):
    screen = console(80, 24)
    table = LiveTable(session(), Output(), screen)
    with table:
        table.add_event(sample_of())
        table.show_notice("Back after 3 s.")
    written = screen.file.getvalue()
    before, _, after = written.rpartition("\x1b[?1049l")  # back from the other screen
    assert "\x1b[?1049h" in before
    assert "\x1b[?25h" in written  # the cursor is seen again
    assert "TWATI" in after
    assert "Ctrl-C" not in after
    assert capsys.readouterr().err == "Back after 3 s.\n"


def test_the_small_curve_spans_its_values_and_keeps_its_width():
    assert sparkline([]) == ""
    assert sparkline([1.0]) == ""
    assert sparkline([0, 1, 2, 3, 4, 5, 6, 7]) == "▁▂▃▄▅▆▇█"
    assert sparkline([5, 5, 5]) == "▁▁▁"
    assert len(sparkline(range(60))) == 20


def test_a_table_without_rows_still_shows_the_state():
    screen = console(80, 24)
    screen.print(table_layout.draw(table_layout.Head("state", "green"), [], 80, 24))
    assert "state" in screen.file.getvalue()
