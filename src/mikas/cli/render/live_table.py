"""The live table of a sampling run, redrawn in place on a terminal.

A value of this cycle is bright; one from an earlier cycle is faded, with its age; in a gap values
are dashes. Without any event, the values fade after 1 s and are dashes after 2 s. A channel in
alarm has a colour and is named in the line above the table.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Self

from mikas.catalog import Level
from mikas.cli.language import current_language, decimal, localized, tr
from mikas.cli.render import table_layout
from mikas.cli.render.output import Output, console
from mikas.cli.render.terminal import out_drawing
from mikas.cli.render.values import fresh_values, reference, unit_text, value_text
from mikas.i18n import Text
from mikas.link import WallClock
from mikas.sampling.alarms import Side
from mikas.sampling.events import AlarmChanged, CycleFailed, LineState, Sampled, StateChanged
from mikas.sampling.gaps import Arrivals, Silence

if TYPE_CHECKING:
    from rich.console import Console, RenderableType

    from mikas.catalog import Derived, InstrumentChannel, Parameter
    from mikas.cli.sampling_run import SamplingRun
    from mikas.client import Reading
    from mikas.client.parameters.derived import DerivedValue
    from mikas.instruments.reading import InstrumentReading
    from mikas.sampling.events import Event

    AnyChannel = Parameter | Derived | InstrumentChannel

_PER_SECOND = 5  # refreshes
_SPARK = "▁▂▃▄▅▆▇█"
_MEMORY = 60  # samples in the trend curve
_WIDTH = 20
_OLD = 1.0  # s; a younger value is faded, without its age, which would only flicker


@dataclass(eq=False)
class LiveTable:
    """A table that is redrawn in place, below a line with the state of the connection.

    A thread of its own draws the table: drawing takes longer than a response, and sampling must not
    wait. The table uses the terminal's alternate screen, so that resizing leaves no remains; at the
    end the last state is printed on the normal screen, and the notices on stderr.
    """

    session: SamplingRun
    output: Output
    console: Console = field(default_factory=lambda: console(out_drawing()))
    clock: Callable[[], float] = field(default_factory=lambda: WallClock().now)

    def __post_init__(self) -> None:
        from rich.live import Live

        names = [channel.name for channel in self.session.channels]
        self._history: dict[str, deque[float]] = {name: deque(maxlen=_MEMORY) for name in names}
        self._latest: dict[str, Reading | DerivedValue | InstrumentReading] = {}
        self._lowest: dict[str, Reading | DerivedValue | InstrumentReading] = {}
        self._highest: dict[str, Reading | DerivedValue | InstrumentReading] = {}
        self._times: deque[float] = deque(maxlen=100)
        self._arrivals = Arrivals()
        self._cycle: Sampled | CycleFailed | None = None
        self._broken: StateChanged | None = None
        self._alarms: dict[str, AlarmChanged] = {}
        self._notices: list[str] = []
        self._changing = threading.Lock()
        self._live = Live(
            console=self.console,
            get_renderable=self.drawing,
            refresh_per_second=_PER_SECOND,
            screen=True,
        )

    def add_event(self, event: Event) -> None:
        """Store the event for the next drawing."""
        with self._changing:
            match event:
                case Sampled():
                    self._sampled(event)
                case CycleFailed():
                    self._cycle = event
                    self._arrivals.interrupt()
                case StateChanged():
                    self._broken = event if event.is_broken else None
                    self._arrivals.interrupt()
                case AlarmChanged():
                    self._alarms.pop(event.name, None)
                    if event.level != Level.NONE:
                        self._alarms[event.name] = event

    def show_notice(self, sentence: str) -> None:
        """Show a notice until the next one; all of them are printed again at the end."""
        with self._changing:
            self._notices.append(sentence)

    def _sampled(self, event: Sampled) -> None:
        self._cycle, self._broken = event, None
        self._times.append(event.time)
        self._arrivals.add(self.clock())
        for name, reading in fresh_values(event).items():
            if name not in self._history:  # an input of a derived channel
                continue
            self._latest[name] = reading
            self._history[name].append(float(reading.value))
            lowest = self._lowest.setdefault(name, reading)
            highest = self._highest.setdefault(name, reading)
            self._lowest[name] = min(lowest, reading, key=lambda r: r.value)
            self._highest[name] = max(highest, reading, key=lambda r: r.value)

    def drawing(self, lines: int | None = None, *, ended: bool = False) -> RenderableType:
        """Return the current table, for the console's size or for so many lines.

        `ended`: as the last event left it; no data are expected since then.
        """
        with self._changing:
            silence = Silence() if ended else self._arrivals.silence(self.clock())
            rows = [self._row(channel, silence) for channel in self.session.channels]
            state = self._state(silence)
            is_well = isinstance(self._cycle, Sampled) and not self._broken and not silence.seconds
            alarms = self._in_alarm()
            notice = self._notices[-1] if self._notices else ""
        width, height = self.console.size
        head = table_layout.Head(
            state, "green" if is_well or self._cycle is None else "red", alarms, notice
        )
        return table_layout.draw(head, rows, width, lines or height)

    def _row(self, channel: AnyChannel, silence: Silence) -> table_layout.Row:
        name = channel.name
        lowest = self._lowest.get(name)
        ranged = lowest if not channel.is_flag else None
        value, style = self._value(channel, silence)
        return table_layout.Row(
            name=name,
            value=value,
            style=style,
            unit=unit_text(lowest) if lowest else channel.unit_text.to(current_language()),
            reference=reference(channel),
            lowest=value_text(ranged) if ranged else "",
            highest=value_text(self._highest[name]) if ranged else "",
            meaning=localized(channel.text),
            curve=sparkline(self._history[name]),
        )

    def _value(self, channel: AnyChannel, silence: Silence) -> tuple[str, str]:
        """Return the text of the value and its style."""
        latest = self._latest.get(channel.name)
        is_lost = self._broken is not None or silence.gone
        if latest is None or is_lost or not isinstance(self._cycle, Sampled):
            return "–", ""
        alarm = self._alarms.get(channel.name)
        style = _STYLES[alarm.level] if alarm else ""
        fresh = channel.name in fresh_values(self._cycle)
        if fresh and not silence.seconds:
            return value_text(latest), style
        age = silence.seconds + (0.0 if fresh else max(0.0, self._cycle.time - latest.time))
        if age < _OLD:
            return value_text(latest), "dim"
        return tr(
            f"{value_text(latest)} ({age:.0f} s)", f"{value_text(latest)} ({age:.0f} с)"
        ), "dim"

    def _in_alarm(self) -> str:
        """Return the alarms, the worst first: `▲ TWAT: DANGER · ▼ UACC: warning`."""
        order = sorted(self._alarms.values(), key=lambda alarm: alarm.level != Level.DANGER)
        arrows: dict[str | None, str] = {Side.HIGH: "▲", Side.LOW: "▼"}
        return " · ".join(
            f"{arrows[alarm.side]} {alarm.name}: {localized(_LEVELS[alarm.level])}"
            for alarm in order
        )

    def _state(self, silence: Silence) -> str:
        model = localized(self.session.model) if self.session.model else "…"
        failed = tr(f"errors {self.session.errors}", f"ошибок {self.session.errors}")
        if self._broken is not None:
            note = tr("waiting, sampling resumes by itself", "ждём, опрос продолжится сам")
            return f"○ {localized(self._broken.text)} · {note} · {model}"
        if self._cycle is None:
            return f"… {tr('waiting for the first response', 'ждём первого ответа')} · {model}"
        if isinstance(self._cycle, CycleFailed):
            return f"○ {localized(self._cycle.error.reason)} · {model} · {failed}"
        if silence.seconds:
            seconds = f"{silence.seconds:.0f}"
            no_data = tr(f"no data for {seconds} s", f"нет данных {seconds} с")
            return f"○ {no_data} · {model} · {failed}"
        sets = decimal(f"{self._rate():.1f}")
        rate = tr(f"{sets} readings/s", f"{sets} опр/с")
        parts = [
            localized(LineState.SAMPLING.text),
            model,
            self.session.acquisition.method or "",
            rate,
            failed,
        ]
        return "● " + " · ".join(word for word in parts if word)

    def _rate(self) -> float:
        if len(self._times) < 2 or self._times[-1] <= self._times[0]:
            return 0.0
        return (len(self._times) - 1) / (self._times[-1] - self._times[0])

    def __enter__(self) -> Self:
        self._live.start(refresh=True)
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self._live.stop()
        if self._cycle:  # at its own end the line has been brought to quiet, which takes a moment
            self.console.print(self.drawing(table_layout.UNLIMITED, ended=kind is None))
        for sentence in self._notices:
            self.output.print_note(sentence)


_LEVELS: dict[str, Text] = {
    Level.WARNING: Text("warning", "предупреждение"),
    Level.DANGER: Text("DANGER", "ОПАСНО"),
}
_STYLES: dict[str, str] = {
    Level.WARNING: "bold yellow",
    Level.DANGER: "bold white on red",
}


def sparkline(values: Sequence[float]) -> str:
    """Draw the last values in at most 20 characters, scaled from their lowest to highest."""
    if len(values) < 2:
        return ""
    step = max(1, len(values) // _WIDTH)
    points = list(values)[::-1][: _WIDTH * step : step][::-1]
    low, high = min(points), max(points)
    scale = (len(_SPARK) - 1) / (high - low) if high > low else 0.0
    return "".join(_SPARK[round((value - low) * scale)] for value in points)
