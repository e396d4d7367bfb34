"""Readings as JSON and as text, with the reference range at warm idle; samples as lines."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Self

from mikas.catalog import Derived, Parameter
from mikas.cli.language import current_language, decimal, tr
from mikas.cli.render.output import Output
from mikas.client import Reading
from mikas.sampling.derived import DerivedValue
from mikas.sampling.events import CycleFailed, Sampled

if TYPE_CHECKING:
    from mikas.cli.sampling_run import SamplingRun
    from mikas.sampling.events import Event


def reading_json(reading: Reading) -> dict[str, Any]:
    """Return `{"value", "unit", "raw", "time"}`: numbers are numbers, flags true or false."""
    return {
        "value": reading.value,
        "unit": reading.unit,
        "raw": reading.raw.hex().upper(),
        "time": round(reading.time, 6),
    }


def value_text(reading: Reading | DerivedValue) -> str:
    """Return the value with its channel's decimals; a flag as yes or no."""
    if isinstance(reading, DerivedValue):
        return decimal(f"{reading.value:.{reading.channel.decimals}f}")
    if isinstance(reading.value, bool):
        return tr("yes", "да") if reading.value else tr("no", "нет")
    return decimal(f"{reading.value:.{reading.parameter.decimals}f}")


def unit_text(reading: Reading | DerivedValue) -> str:
    """Return the unit in the current language."""
    if isinstance(reading, DerivedValue):
        return reading.channel.unit_text.to(current_language())
    return reading.parameter.interpretation(reading.interpretation).unit_text.to(current_language())


def reference(parameter: Parameter | Derived) -> str:
    """Return `13 … 16`, the reference range at warm idle; empty without one."""
    if isinstance(parameter, Derived) or parameter.reference is None:
        return ""
    low, high = parameter.reference
    return decimal(f"{low:g} … {high:g}" if high > low else f"{low:g}")


def valid_reference(reading: Reading) -> str:
    """The reference range; nothing under a reading in which it would not hold."""
    return reference(reading.parameter) if reading.interpretation == "corrected" else ""


class _Lines:
    """The common part of both kinds of lines: notices on stderr."""

    def __init__(self, session: SamplingRun, output: Output) -> None:
        self._channels = session.channels
        self._output = output

    def note(self, sentence: str) -> None:
        self._output.note(sentence)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        return None


class JsonLines(_Lines):
    """`{"time", "values", "gap"}`, one a cycle; in a gap one a try, with its `reason`."""

    def take(self, event: Event) -> None:
        if not isinstance(event, Sampled | CycleFailed):
            return
        fresh = fresh_values(event)
        values = {c.name: fresh[c.name].value if c.name in fresh else None for c in self._channels}
        time = round(event.time, 6)
        line: dict[str, object] = {
            "time": time,
            "values": values,
            "gap": isinstance(event, CycleFailed),
        }
        if isinstance(event, CycleFailed):
            line["reason"] = {"en": event.error.reason.en, "ru": event.error.reason.ru}
        self._output.data(line)


class PlainLines(_Lines):
    """One line per sample, after a heading."""

    def __init__(self, session: SamplingRun, output: Output) -> None:
        super().__init__(session, output)
        self._has_heading = False

    def take(self, event: Event) -> None:
        if not isinstance(event, Sampled | CycleFailed):
            return
        if not self._has_heading:  # not before there is something: an error needs no heading
            self._has_heading = True
            names = (channel.name for channel in self._channels)
            self._output.line("\t".join([tr("time", "время"), *names]))
        fresh = fresh_values(event)
        cells = (
            value_text(fresh[channel.name]) if channel.name in fresh else "–"
            for channel in self._channels
        )
        self._output.line("\t".join([decimal(f"{event.time:.3f}"), *cells]))


def fresh_values(event: Sampled | CycleFailed) -> dict[str, Reading | DerivedValue]:
    """Return the values read in this cycle, by name; none in a gap."""
    return {**event.fresh, **event.derived} if isinstance(event, Sampled) else {}
