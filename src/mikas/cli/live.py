"""The live table of `watch`, and what stands for it where there is no terminal."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Protocol, Self

from mikas.catalog import Parameter
from mikas.cli.output import Output, make_table, stdout_console
from mikas.cli.readings import reference, shown_unit, shown_value
from mikas.cli.words import language, say, shown
from mikas.client import Ecu, Reading, Sample
from mikas.errors import MikasError

if TYPE_CHECKING:
    from rich.console import Group

_PER_SECOND = 10  # refreshes: more than an eye reads, and the wire's time is not spent on drawing
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

    def show(self, sample: Sample) -> None:
        cells = [f"{sample.time:.3f}"]
        for parameter in self._wanted:
            reading = sample.readings.get(parameter.name)
            cells.append(shown_value(reading) if reading else "–")
        self._output.line("\t".join(cells))

    def __enter__(self) -> Self:
        self._output.line("\t".join([say("time", "время"), *(p.name for p in self._wanted)]))
        return self

    def __exit__(self, *_: object) -> None:
        return None


class LiveTable:
    """A table that is redrawn in place, with a line on what the wire does above it."""

    def __init__(self, ecu: Ecu, wanted: Sequence[Parameter]) -> None:
        from rich.live import Live

        self._ecu = ecu
        self._wanted = wanted
        self._past: dict[str, deque[float]] = {p.name: deque(maxlen=_MEMORY) for p in wanted}
        self._lowest: dict[str, Reading] = {}
        self._highest: dict[str, Reading] = {}
        self._times: deque[float] = deque(maxlen=100)
        self._drawn = float("-inf")
        self._live = Live(
            console=stdout_console(), auto_refresh=False, vertical_overflow="crop", transient=False
        )

    def show(self, sample: Sample) -> None:
        self._times.append(sample.time)
        for name, reading in sample.readings.items():
            self._past[name].append(float(reading.value))
            lowest = self._lowest.setdefault(name, reading)
            highest = self._highest.setdefault(name, reading)
            self._lowest[name] = min(lowest, reading, key=lambda r: r.value)
            self._highest[name] = max(highest, reading, key=lambda r: r.value)
        now = self._ecu.tester.link.now()
        if now - self._drawn >= 1 / _PER_SECOND:
            self._drawn = now
            self._live.update(self._drawing(sample), refresh=True)

    def _drawing(self, sample: Sample) -> Group:
        from rich.console import Group
        from rich.text import Text as RichText

        table = make_table(
            [
                say("name", "имя"), say("value", "значение"), say("unit", "ед."), say("min", "мин"),
                say("max", "макс"), "", say("warm idle", "на хх"), say("meaning", "что это"),
            ],
            [self._row(parameter, sample) for parameter in self._wanted],
            right="134",
        )  # fmt: skip
        style = "red" if sample.gap else "green"
        return Group(RichText(self._state(sample), style=style), table)

    def _row(self, parameter: Parameter, sample: Sample) -> list[str]:
        name = parameter.name
        reading = sample.readings.get(name)
        told = self._lowest.get(name)
        return [
            name,
            shown_value(reading) if reading else "–",
            shown_unit(told) if told else parameter.unit_text.to(language()),
            shown_value(told) if told and not parameter.is_flag else "",
            shown_value(self._highest[name]) if told and not parameter.is_flag else "",
            sparkline(self._past[name]),
            reference(parameter),
            shown(parameter.text),
        ]

    def _state(self, sample: Sample) -> str:
        statistics = self._ecu.tester.statistics
        model = shown(self._ecu.model.text)
        failed = say(f"errors {statistics.failed}", f"ошибок {statistics.failed}")
        if sample.gap:
            reason = sample.reason
            why = reason.reason.to(language()) if isinstance(reason, MikasError) else str(reason)
            return f"○ {why} · {model} · {failed}"
        rate = say(f"{self._rate():.1f} sets/s", f"{self._rate():.1f} наб/с")
        return f"● {say('ECU answers', 'блок отвечает')} · {model} · {rate} · {failed}"

    def _rate(self) -> float:
        if len(self._times) < 2 or self._times[-1] <= self._times[0]:
            return 0.0
        return (len(self._times) - 1) / (self._times[-1] - self._times[0])

    def __enter__(self) -> Self:
        self._live.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._live.stop()


def sparkline(values: Sequence[float]) -> str:
    """The last values as a small curve of at most 20 characters, from their own low to high."""
    if len(values) < 2:
        return ""
    step = max(1, len(values) // _WIDTH)
    shown_ones = list(values)[::-1][: _WIDTH * step : step][::-1]
    low, high = min(shown_ones), max(shown_ones)
    scale = (len(_SPARK) - 1) / (high - low) if high > low else 0.0
    return "".join(_SPARK[round((value - low) * scale)] for value in shown_ones)
