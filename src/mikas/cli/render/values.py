"""Readings as JSON and as text, with the reference range at warm idle; samples as lines."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from mikas.catalog import Confidence, Derived, InstrumentChannel, Parameter
from mikas.catalog.undecided import READING_NAMES, values_otherwise
from mikas.cli.language import current_language, decimal, tr
from mikas.cli.render.output import Output
from mikas.client import Reading
from mikas.client.parameters.derived import DerivedValue
from mikas.i18n import Text
from mikas.instruments.reading import InstrumentReading
from mikas.json_values import picked
from mikas.sampling.events import CycleFailed, Sampled

if TYPE_CHECKING:
    from mikas.cli.sampling_run import SamplingRun
    from mikas.sampling.events import Event

CONFIDENCE: Final = {
    Confidence.CONFIRMED: Text("confirmed", "подтверждено"),
    Confidence.REPORTED: Text("one source", "один источник"),
    Confidence.UNCONFIRMED: Text("unconfirmed", "не подтверждено"),
    Confidence.UNKNOWN: Text("unknown", "неизвестно"),
}
"""Each confidence in words, as a cell of a table."""


def reading_json(reading: Reading | DerivedValue) -> dict[str, Any]:
    """Return `{"value", "unit", "raw", "time"}`: numbers are numbers, flags true or false.

    A derived value has no `raw`, and its `inputs`; where the formula has no result it is null.
    A value that can be read otherwise (E3) has its `otherwise`, by interpretation.
    """
    time = round(reading.time, 6)
    if isinstance(reading, Reading):
        raw = reading.raw.hex().upper()
        found = picked(reading, "value", "unit") | {"raw": raw, "time": time}
        others = _otherwise(reading)
        return found | {"otherwise": others} if others else found
    value = reading.value if reading.has_value else None
    inputs = {name: each.value for name, each in reading.inputs.items()}
    return {"value": value, "unit": reading.unit, "raw": None, "time": time, "inputs": inputs}


def value_text(reading: Reading | DerivedValue | InstrumentReading) -> str:
    """Return the value with its channel's decimals; a flag as yes or no."""
    if isinstance(reading, InstrumentReading):
        return decimal(f"{reading.value:.{reading.channel.decimals}f}")
    if isinstance(reading, DerivedValue):
        if not reading.has_value:
            return "–"
        return decimal(f"{reading.value:.{reading.channel.decimals}f}")
    if isinstance(reading.value, bool):
        return tr("yes", "да") if reading.value else tr("no", "нет")
    return decimal(f"{reading.value:.{reading.parameter.decimals}f}")


def reading_name(interpretation: str) -> str:
    """Return the word for an interpretation, in the current language."""
    return READING_NAMES[interpretation].to(current_language())


def _otherwise(reading: Reading) -> dict[str, float]:
    return values_otherwise(reading.parameter, reading.raw, reading.interpretation)


def meaning_text(reading: Reading | DerivedValue) -> str:
    """Return the channel's text; behind it the value by the readings that only a car decides on."""
    text = reading.channel.text.to(current_language())
    if isinstance(reading, DerivedValue):
        return text
    places = reading.parameter.decimals
    others = [
        f"{reading_name(name)} {decimal(f'{value:.{places}f}')}"
        for name, value in _otherwise(reading).items()
    ]
    return "; ".join([text, *others])


def unit_text(reading: Reading | DerivedValue | InstrumentReading) -> str:
    """Return the unit in the current language."""
    if isinstance(reading, DerivedValue | InstrumentReading):
        return reading.channel.unit_text.to(current_language())
    return reading.parameter.interpretation(reading.interpretation).unit_text.to(current_language())


def reference(parameter: Parameter | Derived | InstrumentChannel) -> str:
    """Return `13 … 16`, the reference range at warm idle; empty without one."""
    if isinstance(parameter, InstrumentChannel) or parameter.reference is None:
        return ""
    low, high = parameter.reference
    return decimal(f"{low:g} … {high:g}" if high > low else f"{low:g}")


def json_line(session: SamplingRun, output: Output, event: Event) -> None:
    """Print `{"time", "values", "gap"}`, one a cycle; in a gap one a try, with its `reason`."""
    if not isinstance(event, Sampled | CycleFailed):
        return
    fresh, names = fresh_values(event), [each.name for each in session.channels]
    line: dict[str, object] = {
        "time": round(event.time + session.later, 6),
        "values": {name: fresh[name].value if name in fresh else None for name in names},
        "gap": isinstance(event, CycleFailed),
    }
    if isinstance(event, CycleFailed):
        line["reason"] = event.error.reason._asdict()
    output.data(line)


def plain_line(session: SamplingRun, output: Output, event: Event) -> None:
    """Print one line per cycle, the first one after a heading: an error alone needs no heading."""
    if not isinstance(event, Sampled | CycleFailed):
        return
    fresh, names = fresh_values(event), [each.name for each in session.channels]
    if session.samples + session.gap_cycles == 1:
        output.line("\t".join([tr("time", "время"), *names]))
    cells = (value_text(fresh[name]) if name in fresh else "–" for name in names)
    output.line("\t".join([decimal(f"{event.time + session.later:.3f}"), *cells]))


def fresh_values(
    event: Sampled | CycleFailed,
) -> dict[str, Reading | DerivedValue | InstrumentReading]:
    """Return the values read in this cycle, by name, and the instruments'; none in a gap."""
    if not isinstance(event, Sampled):
        return {}
    return {**event.fresh, **event.derived, **event.instruments}
