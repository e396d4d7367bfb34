"""The live table of `watch`, and what stands for it where there is no terminal."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Protocol, Self

from mikas.catalog import Parameter
from mikas.cli import layout
from mikas.cli.output import Output, stdout_console
from mikas.cli.readings import reference, shown_unit, shown_value
from mikas.cli.words import decimal, language, say, shown
from mikas.client import Ecu, Reading, Sample
from mikas.errors import MikasError

if TYPE_CHECKING:
    from rich.console import Console, RenderableType

_PER_SECOND = 5  # refreshes, as many as an eye can follow
_SPARK = "▁▂▃▄▅▆▇█"
_MEMORY = 60  # samples that the small curve shows, joined to its width
_WIDTH = 20


class Shown(Protocol):
    """Something that samples are shown on."""

    def show(self, sample: Sample) -> None:
        """Shows `sample` now."""

    def __enter__(self) -> Self: ...

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None: ...


class PlainLines:
    """A line a sample, cells parted by tabs, a heading first."""

    def __init__(self, output: Output, wanted: Sequence[Parameter]) -> None:
        self._output = output
        self._wanted = wanted
        self._begun = False

    def show(self, sample: Sample) -> None:
        if not self._begun:  # not before there is something: an error needs no heading
            self._begun = True
            names = (p.name for p in self._wanted)
            self._output.line("\t".join([say("time", "время"), *names]))
        cells = [decimal(f"{sample.time:.3f}")]
        for parameter in self._wanted:
            reading = sample.readings.get(parameter.name)
            cells.append(shown_value(reading) if reading else "–")
        self._output.line("\t".join(cells))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        return None


class LiveTable:
    """A table that is redrawn in place, with a line on what the wire does above it.

    It is drawn in a thread of its own: a drawing takes longer than a request's turn-round, and the
    wire must not wait for it.

    It has the terminal's other screen, so that a change of its size leaves no rubbish; at the end
    the last state is left on the usual one.
    """

    def __init__(
        self, ecu: Ecu, wanted: Sequence[Parameter], console: Console | None = None
    ) -> None:
        from rich.live import Live

        self._ecu = ecu
        self._wanted = wanted
        self._console = console or stdout_console()
        self._past: dict[str, deque[float]] = {p.name: deque(maxlen=_MEMORY) for p in wanted}
        self._lowest: dict[str, Reading] = {}
        self._highest: dict[str, Reading] = {}
        self._times: deque[float] = deque(maxlen=100)
        self._sample: Sample | None = None
        self._changing = threading.Lock()
        self._live = Live(
            console=self._console,
            get_renderable=self.drawing,
            refresh_per_second=_PER_SECOND,
            screen=True,
        )

    def show(self, sample: Sample) -> None:
        with self._changing:
            self._take(sample)

    def _take(self, sample: Sample) -> None:
        self._sample = sample
        self._times.append(sample.time)
        for name, reading in sample.readings.items():
            self._past[name].append(float(reading.value))
            lowest = self._lowest.setdefault(name, reading)
            highest = self._highest.setdefault(name, reading)
            self._lowest[name] = min(lowest, reading, key=lambda r: r.value)
            self._highest[name] = max(highest, reading, key=lambda r: r.value)

    def drawing(self, lines: int | None = None) -> RenderableType:
        """The table as it is now, for the console's size, or for so many lines."""
        with self._changing:
            rows = [self._row(parameter) for parameter in self._wanted]
            state = self._state()
            style = "red" if self._sample and self._sample.gap else "green"
        width, height = self._console.size
        return layout.draw(state, style, rows, width, lines or height)

    def _row(self, parameter: Parameter) -> layout.Row:
        name = parameter.name
        reading = self._sample.readings.get(name) if self._sample else None
        told = self._lowest.get(name)
        ranged = told if not parameter.is_flag else None
        return layout.Row(
            name=name,
            value=shown_value(reading) if reading else "–",
            unit=shown_unit(told) if told else parameter.unit_text.to(language()),
            reference=reference(parameter),
            lowest=shown_value(ranged) if ranged else "",
            highest=shown_value(self._highest[name]) if ranged else "",
            meaning=shown(parameter.text),
            curve=sparkline(self._past[name]),
        )

    def _state(self) -> str:
        model = shown(self._ecu.model.text)
        if self._sample is None:
            return f"… {say('waiting for the first answer', 'ждём первого ответа')} · {model}"
        errors = self._ecu.tester.statistics.failed
        failed = say(f"errors {errors}", f"ошибок {errors}")
        if self._sample.gap:
            reason = self._sample.reason
            why = shown(reason.reason) if isinstance(reason, MikasError) else str(reason)
            return f"○ {why} · {model} · {failed}"
        sets = decimal(f"{self._rate():.1f}")
        rate = say(f"{sets} sets/s", f"{sets} раз/с")
        return f"● {say('ECU answers', 'блок отвечает')} · {model} · {rate} · {failed}"

    def _rate(self) -> float:
        if len(self._times) < 2 or self._times[-1] <= self._times[0]:
            return 0.0
        return (len(self._times) - 1) / (self._times[-1] - self._times[0])

    def __enter__(self) -> Self:
        self._live.start(refresh=True)
        return self

    def __exit__(self, *_: object) -> None:
        self._live.stop()
        if self._sample:
            self._console.print(self.drawing(layout.UNLIMITED))


def sparkline(values: Sequence[float]) -> str:
    """The last values as a small curve of at most 20 characters, from their own low to high."""
    if len(values) < 2:
        return ""
    step = max(1, len(values) // _WIDTH)
    shown_ones = list(values)[::-1][: _WIDTH * step : step][::-1]
    low, high = min(shown_ones), max(shown_ones)
    scale = (len(_SPARK) - 1) / (high - low) if high > low else 0.0
    return "".join(_SPARK[round((value - low) * scale)] for value in shown_ones)
