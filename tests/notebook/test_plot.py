"""`recording.plot()`: the panes, lines and texts of a real figure, drawn by Agg."""

from __future__ import annotations

import io
import subprocess
import sys
from datetime import datetime
from itertools import pairwise
from math import isnan

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import pyplot as plt
from matplotlib.colors import to_rgb
from notebook_harness import NOON, of_a_car, of_values

import mikas
from drives.drive_rig import Road, Session, Unit, recorded
from mikas.errors import MissingExtra, UnknownParameter, UsageError
from mikas.i18n import Text
from mikas.notebook.panes import DAY, FIRST, NIGHT
from mikas.sampling.events import AlarmChanged, Gap, LineState, Marker, StateChanged

WHY = Text("a long text about what to do $x$", "длинный текст о том, что делать")
DANGER = AlarmChanged(
    NOON + 8, "FREQ", "danger", "none", "high", 7000.0, 6500.0, Text("too fast", "быстро")
)


@pytest.fixture(autouse=True)
def figures():
    mpl.use("Agg")
    with mpl.rc_context():
        yield
    plt.close("all")


@pytest.fixture(scope="module")
def car(tmp_path_factory):
    return mikas.open(of_a_car(tmp_path_factory.mktemp("car") / "drive.pcapng"), language="en")


@pytest.fixture(scope="module")
def hill(tmp_path_factory):
    """Ten seconds with one spike and a gap from 4 to 6 s."""
    values = [(n / 10, 200 if n == 20 else 21 + n % 2) for n in range(100) if not 40 < n < 60]
    events = (
        Gap(NOON + 4.1, NOON + 4.1, NOON + 5.9, WHY),
        StateChanged(NOON + 5, LineState.ECHO_ONLY, reason=WHY),
        Marker(NOON + 2.5, "$hill$ \\frac _x"),
        Marker(NOON + 2.51, "and again"),
        DANGER,
    )
    path = of_values(tmp_path_factory.mktemp("hill") / "a$b$.pcapng", values, *events)
    return mikas.open(path, language="en")


def png(plot):
    """The figure as a picture: its pixels."""
    file = io.BytesIO()
    plot.figure.savefig(file, format="png", dpi=60)
    file.seek(0)
    return plt.imread(file)


def labels(pane):
    return [text.get_text() for text in pane.get_legend().get_texts()]


def annotations(pane):
    return [text.get_text() for text in pane.texts]


def test_it_draws_the_panes_of_the_chart(car):
    plot = car.plot()
    assert [labels(pane) for pane in plot.panes] == [
        ["Crankshaft speed, rpm", "Throttle position, %"],
        ["Injection pulse, ms", "Air flow, kg/h"],
        ["Ignition advance, ° crank"],
        ["Coolant temperature, °C", "Battery voltage, V"],
    ]
    names = [name for pane in FIRST for name in pane]
    assert list(plot.axes) == list(plot.lines) == names
    assert [plot.lines[name].get_color() for name in names] == list(DAY.traces[: len(names)])
    for name in names:
        rows = car.to_pandas()[name].dropna()
        line = plot.lines[name]
        inside = np.isfinite(line.get_ydata())
        np.testing.assert_allclose(line.get_xdata()[inside], rows.index, atol=1e-6)
        np.testing.assert_array_equal(line.get_ydata()[inside], rows)
    assert plot.axes["FREQ"] is plot.panes[0]
    assert plot.axes["THR"].yaxis.get_ticks_position() == "right"
    pixels = png(plot)
    assert pixels.shape[1] == 600
    assert len(np.unique(pixels.reshape(-1, pixels.shape[2]), axis=0)) > 50


def test_the_panes_are_those_that_are_named(car):
    plot = car.plot(["FREQ", "RXX", "DET"], "TWAT", by_unit=False)
    assert [labels(pane) for pane in plot.panes] == [
        ["Crankshaft speed, rpm", "Idle", "Knock present"], ["Coolant temperature, °C"],
    ]  # fmt: skip
    lanes = [plot.axes[name].transData.transform((0, value))[1]
             for name in ("RXX", "DET") for value in (0, 1)]  # fmt: skip
    assert lanes == sorted(lanes)  # one above the other
    assert len({plot.axes[name] for name in ("FREQ", "RXX", "DET")}) == 3
    assert not plot.axes["RXX"].yaxis.get_visible()
    assert plot.lines["RXX"].get_drawstyle() == "steps-post"
    by_unit = car.plot(["FREQ", "TWAT"], ["FREQX", "TAIR"], by_unit=True)
    assert [len(pane.get_legend().get_texts()) for pane in by_unit.panes] == [2, 2]
    everything = car.plot(by_unit=True)
    assert set(everything.lines) == {channel.name for channel in car.channels}
    assert png(everything).size


def test_stacked_lines_have_lanes_of_their_own(car):
    plot = car.plot(["FREQ", "TWAT", "RXX"], stacked=True)
    heights = []
    for name in ("FREQ", "TWAT", "RXX"):
        values = plot.lines[name].get_ydata()
        transform = plot.axes[name].transData.transform
        heights.append([transform((0, v))[1] for v in (np.nanmin(values), np.nanmax(values))])
        assert not plot.axes[name].yaxis.get_visible()
    assert heights[2][1] < heights[1][0] <= heights[1][1] < heights[0][0]


def test_gaps_are_hatched_break_the_line_and_say_why(hill):
    plot = hill.plot("FREQ")
    (pane,) = plot.panes
    line = plot.lines["FREQ"]
    times, values = line.get_xdata(), line.get_ydata()
    hole = times[np.isnan(values)]
    assert hole.size == 1
    assert 4 <= hole[0] <= 6
    (hatched,) = [it for it in pane.collections if it.get_hatch()]
    (span,) = [path.get_extents() for path in hatched.get_paths()]
    assert (span.x0, span.x1) == pytest.approx((4.09, 5.89), abs=0.02)
    assert any("echo, but the ECU" in text.replace("\n", " ") for text in annotations(pane))
    assert png(plot).size


def test_a_session_that_ends_in_a_gap_leaves_the_next_ones_values_alone(tmp_path):
    lively = [(n / 10, 20 + n % 3) for n in range(50)]
    first = of_values(tmp_path / "1.pcapng", lively, Gap(NOON + 4.95, NOON + 4.95, None))
    second = of_values(tmp_path / "2.pcapng", lively, zero=NOON + 60)
    first.write_bytes(first.read_bytes() + second.read_bytes())
    recording = mikas.open(first)
    plot = recording.plot("FREQ")
    assert np.isnan(plot.lines["FREQ"].get_ydata()).sum() == 1
    (hatched,) = [it for it in plot.panes[0].collections if it.get_hatch()]
    assert hatched.get_paths()[0].get_extents().x1 == pytest.approx(60, abs=0.1)
    (channel,) = [it for it in recording.overview.channels if it.channel.name == "FREQ"]
    assert sum(isnan(value) for _, value in channel.curve) == 1


def of_colour(plot, name):
    """How many pixels of a pane's picture have the colour of a line."""
    plot.panes[0].get_legend().remove()
    pixels = png(plot)[:, :, :3]
    return int((abs(pixels - to_rgb(plot.lines[name].get_color())).max(axis=2) < 0.1).sum())


def test_a_value_that_stands_alone_is_seen(tmp_path):
    """Alone in the recording, or between two gaps: a line has two ends."""
    one = mikas.open(of_values(tmp_path / "one.pcapng", [(0, 20)])).plot("FREQ")
    assert of_colour(one, "FREQ") > 3
    lively = [(n / 10, 20) for n in range(20)]
    later = [(100 + time, raw) for time, raw in lively]
    between, without = (
        mikas.open(of_values(tmp_path / f"{len(values)}.pcapng", values)).plot("FREQ")
        for values in ([*lively, (50, 20), *later], [*lively, *later])
    )
    assert of_colour(between, "FREQ") > of_colour(without, "FREQ") + 3
    assert list(between.lines["FREQ"].get_markevery()) == [21]
    assert without.lines["FREQ"].get_marker() in ("", "None")


def test_markers_and_alarms_stand_over_the_panes_as_they_were_written(hill):
    plot = hill.plot("FREQ", "FREQ")
    words = annotations(plot.panes[0])
    assert "⚑ $hill$ \\frac _x ×2" in words  # two that are near are one; no mathematics
    assert "▲ too fast" in words
    for pane in plot.panes:
        verticals = [it.get_xdata()[0] for it in pane.lines if len(it.get_xdata()) == 2]
        assert verticals == pytest.approx([2.49, 7.99], abs=0.02)
    assert plot.figure.texts[0].get_text().startswith("a$b$.pcapng · ")
    assert png(plot).size


def test_a_window_is_given_in_seconds_or_dates(hill):
    one = hill.plot("FREQ", start=2, end=3)
    assert one.panes[0].get_xlim() == (2, 3)
    first = hill.span[0]
    two = hill.plot(
        "FREQ", start=datetime.fromtimestamp(first + 2), end=datetime.fromtimestamp(first + 3)
    )
    assert two.panes[0].get_xlim() == pytest.approx((2, 3), abs=1e-5)
    assert two.lines["FREQ"].get_ydata().max() == 8000
    assert hill.plot("FREQ", start=8).panes[0].get_xlim()[1] == pytest.approx(9.9 + 0.099)


def test_the_time_axis_has_times_of_day_or_seconds_since_the_start(hill, car):
    def ticks(plot):
        plot.figure.canvas.draw()
        return [it.get_text() for it in plot.panes[-1].get_xticklabels()]

    assert [it[-3:] for it in ticks(hill.plot("FREQ"))[:2]] == [":20", ":22"]
    assert ticks(hill.plot("FREQ", start=2, end=2.5))[0][-3:] == "2.1"
    assert ticks(car.plot("FREQ"))[0] == "0:00.0"


def test_a_spike_stays_and_an_hour_has_few_points(tmp_path):
    values = [(n * 0.18, 190 if n == 12_345 else 20 + n % 3) for n in range(20_000)]
    recording = mikas.open(of_values(tmp_path / "hour.pcapng", values))
    plot = recording.plot("FREQ")
    assert len(plot.lines["FREQ"].get_xdata()) <= 2000
    assert plot.lines["FREQ"].get_ydata().max() == 7600
    assert plot.lines["FREQ"].get_ydata().min() == 800
    assert not np.isnan(plot.lines["FREQ"].get_ydata()).any()
    assert len(recording.plot("FREQ", points=100).lines["FREQ"].get_xdata()) <= 100
    assert len(recording._repr_html_()) < 10_000


def test_a_slow_channel_is_no_gap_beside_a_fast_one(tmp_path):
    path = tmp_path / "it.pcapng"
    of_values(path, [(n * 2.0, 120 + n % 2) for n in range(40)], code=0x1A)
    line = mikas.open(path).plot("TWAT").lines["TWAT"]
    assert not np.isnan(line.get_ydata()).any()


def test_the_reference_is_a_stripe_behind_the_line(car):
    plain, shown = car.plot("TWAT"), car.plot("TWAT", reference=True)
    assert len(shown.axes["TWAT"].patches) == len(plain.axes["TWAT"].patches) + 1
    low, high = shown.axes["TWAT"].get_ylim()
    assert low < 80
    assert high > 95


def test_one_pane_is_drawn_into_an_axes_of_ones_own(car):
    figure, (left, right) = plt.subplots(1, 2)
    plot = car.plot("FREQ", "TWAT", ax=right)
    assert plot.figure is figure
    assert plot.panes == (right,)
    assert set(plot.lines) == {"FREQ", "TWAT"}
    assert not left.lines


def test_dark_figures_have_the_colours_of_the_night(car):
    plt.style.use("dark_background")
    assert car.plot("FREQ").lines["FREQ"].get_color() == NIGHT.traces[0]


def test_two_lines_that_are_the_same_do_not_cover_each_other(tmp_path):
    own = tmp_path / "own.toml"
    own.write_text(
        '[derived.TWICE]\nformula = "FREQ"\nunit = "rpm"\ntext = { en = "A", ru = "A" }\n'
    )
    path = of_values(tmp_path / "it.pcapng", [(n / 10, 20 + n % 2) for n in range(50)])
    plot = mikas.open(path, catalogs=[own]).plot(["FREQ", "TWICE"])
    one, two = (it.get_transform().transform((0, 800))[1] for it in plot.lines.values())
    assert two - one == pytest.approx(3)  # pixels


def test_wrong_use_is_said_in_words(car, hill, tmp_path):
    with pytest.raises(UnknownParameter, match="Did you mean FREQ"):
        car.plot("FREK")
    with pytest.raises(UsageError, match="UOZ is not among this recording's channels: FREQ"):
        hill.plot("UOZ")
    for start, end in ((5, 2), (99, None), (3, 3)):
        with pytest.raises(UsageError, match="ends before it begins"):
            hill.plot("FREQ", start=start, end=end)
    for wrong in ("5", float("nan"), True):
        with pytest.raises(UsageError, match="seconds from the first row"):
            hill.plot("FREQ", start=wrong)
    with pytest.raises(UsageError, match="has no date"):
        car.plot("FREQ", start=datetime(2026, 1, 1))
    with pytest.raises(UsageError, match="at least 10"):
        car.plot(points=1)
    with pytest.raises(UsageError, match="no values to draw"):
        mikas.open(of_values(tmp_path / "empty.pcapng", [])).plot()


def test_without_matplotlib_the_error_names_the_command(car, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(MissingExtra) as error:
        car.plot()
    assert 'pip install "mikas[plot]"' in str(error.value)
    assert 'pip install "mikas[plot]"' in error.value.text.ru


def test_neither_opening_nor_showing_imports_matplotlib(car):
    code = (
        "import mikas, sys; r = mikas.open(sys.argv[1]); r._repr_html_(); "
        "print('matplotlib' in sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(car.path)], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "False"


def test_a_figure_is_shown_once(car, monkeypatch):
    shown = []
    monkeypatch.setattr("IPython.display.display", shown.append)
    plot = car.plot("FREQ")
    plot._ipython_display_()  # the notebook shows open figures at the end of the cell
    assert shown == []
    plt.close(plot.figure)
    plot._ipython_display_()
    assert shown == [plot.figure]


def test_flags_that_stand_close_have_no_more_text_than_room(tmp_path):
    values = [(n * 2.0, 20 + n % 3) for n in range(1000)]
    for distance in (10, 60, 150, 400):
        times = range(0, 2000, distance)
        markers = [Marker(NOON + time, f"a marker at {time} s") for time in times]
        path = of_values(tmp_path / f"{distance}.pcapng", values, *markers)
        plot = mikas.open(path).plot("FREQ")
        plot.figure.canvas.draw()
        boxes = [text.get_window_extent() for text in plot.panes[0].texts]
        assert bool(boxes) == (distance > 10)
        assert all(one.x1 <= two.x0 + 12 for one, two in pairwise(boxes))
        assert all(box.x1 <= plot.panes[0].get_window_extent().x1 + 12 for box in boxes)
        lines = [it for it in plot.panes[0].lines if len(it.get_xdata()) == 2]
        assert len(lines) == (67 if distance == 10 else len(times))  # three of 10 s are one
    (at_the_end,) = (
        mikas.open(of_values(tmp_path / "b.pcapng", values, Marker(NOON + 1990, "the end of it")))
        .plot("FREQ")
        .panes[0]
        .texts
    )
    assert at_the_end.get_text() == "⚑ the end of it"
    assert at_the_end.get_ha() == "right"


def test_a_clock_that_jumped_by_a_century_has_few_labels(tmp_path):
    values = [(n * 0.5, 20) for n in range(20)] + [(3e9 + n, 21) for n in range(20)]
    plot = mikas.open(of_values(tmp_path / "it.pcapng", values)).plot("FREQ")
    plot.figure.canvas.draw()
    assert 2 < len(plot.panes[0].get_xticks()) < 12
    (cut,) = np.flatnonzero(np.isnan(plot.lines["FREQ"].get_ydata()))
    assert plot.lines["FREQ"].get_xdata()[cut] == pytest.approx(9.5, abs=0.1)


def test_numbers_of_numpy_are_seconds_too(hill):
    plot = hill.plot("FREQ", start=np.int64(2), end=np.float32(3))
    assert plot.panes[0].get_xlim() == (2, 3)


def test_instruments_beside_the_unit_are_shown_and_plotted(tmp_path):
    road = [Road(float(at), 36.0, lambda_=0.98) for at in range(20)]
    path = tmp_path / "drive.pcapng"
    recorded(path, Session([Unit(at + 0.5, 1200, 7.2) for at in range(20)], road))
    recording = mikas.open(path)
    assert "Latitude by GPS" in recording._repr_html_()
    plot = recording.plot("FREQ", ["lambda", "GPS_SPEED"])
    assert set(plot.lines) == {"FREQ", "LAMBDA", "GPS_SPEED"}
    assert set(plot.lines["GPS_SPEED"].get_ydata()) == {36.0}
    legend = [text.get_text() for text in plot.panes[1].get_legend().get_texts()]
    assert legend == ["λ, measured, λ", "Speed by GPS, km/h"]
