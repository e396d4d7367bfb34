"""The definition of a channel, as the page and scripts get it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import BaseModel, Field

from mikas.catalog import Catalog, Confidence, Derived, Level, Parameter, shipped
from mikas.dashboard.api.errors import Described, TwoTexts, made_of, two, two_or_none


class ChannelLimits(Described):
    """The limits of a channel; a value beyond one is an alarm."""

    danger_low: float | None
    warning_low: float | None
    warning_high: float | None
    danger_high: float | None
    hysteresis: Annotated[float, Field(description="how far inside a limit its alarm ends")] = 0


class LampTexts(Described):
    """The texts of a flag's lamp."""

    on: TwoTexts
    off: TwoTexts
    trouble: Level = Field(description="its colour while on; that is no alarm")


class ChannelErratum(BaseModel):
    """An erratum of the source that concerns this channel."""

    id: str
    text: TwoTexts


class ChannelMeaning(BaseModel):
    """Causes of a value below or above the reference, and what to check; null: unknown."""

    low: TwoTexts | None
    high: TwoTexts | None
    confidence: Confidence


class ChannelInfo(BaseModel):
    """A parameter, or a derived channel (`inputs`; no code and no size).

    `own`: the keys that the user's own catalog sets; `mine`: the whole channel is defined there.
    """

    name: str
    derived: bool
    flag: bool
    code: int | None
    size: int | None
    unit: TwoTexts
    unit_key: str = Field(description="as in the catalog's `units`; else the text itself")
    text: TwoTexts
    short: TwoTexts = Field(description="the text of a small tile")
    decimals: int
    formula: str
    range: tuple[float, float] | None
    reference: tuple[float, float] | None = Field(description="warm idle of a sound engine")
    gauge: tuple[float, float] | None = Field(
        description="the scale of its gauge; null: a flag, or a derived channel without one"
    )
    span_least: float | None = Field(
        description="the least span of an axis of its values; null: a flag"
    )
    limits: ChannelLimits | None
    lamp: LampTexts | None
    alarm_when_true: Level
    inputs: list[str] | None
    errata: list[ChannelErratum]
    confidence: Confidence
    source: str
    reference_confidence: Confidence
    range_kind: Literal["plausible", "representable", ""]
    meaning: ChannelMeaning | None
    constants: dict[str, float]
    accumulates: bool
    own: list[str]
    mine: bool
    writable: bool


Entries = Mapping[tuple[str, str], Mapping[str, object]]
"""The entries of the own file, as `OwnCatalog.entries`."""


def channel_info(known: Catalog, channel: Parameter | Derived, own: Entries) -> ChannelInfo:
    """Return a channel of the catalog; `own`: the entries of the own file."""
    parameter = channel if isinstance(channel, Parameter) else None
    derived = channel if isinstance(channel, Derived) else None
    family = "derived" if derived else "parameter"
    keys = own.get((family, channel.name), {})
    meaning = parameter.meaning if parameter else None
    limits, lamp = channel.alarm_limits, parameter.lamp if parameter else None
    return made_of(
        ChannelInfo,
        channel,
        derived=parameter is None,
        flag=channel.is_flag,
        code=parameter.code if parameter else None,
        size=parameter.size if parameter else None,
        unit=channel.unit_text,
        formula=channel.formula() if isinstance(channel, Parameter) else channel.formula,
        range=parameter.range if parameter else None,
        reference=parameter.reference if parameter else None,
        gauge=channel.gauge_scale,
        span_least=channel.least_span,
        limits=limits if limits and limits.for_number else None,
        lamp=lamp,
        alarm_when_true=limits.when_true if limits else Level.NONE,
        inputs=None if isinstance(channel, Parameter) else channel.inputs,
        errata=[
            ChannelErratum(id=name, text=two(known.errata[name].reason))
            for name in (parameter.errata if parameter else ())
        ],
        unit_key=channel.unit,
        reference_confidence=parameter.reference_confidence if parameter else Confidence.UNKNOWN,
        range_kind=parameter.range_kind if parameter else "",
        meaning=meaning
        and ChannelMeaning(
            low=two_or_none(meaning.low),
            high=two_or_none(meaning.high),
            confidence=meaning.confidence,
        ),
        constants=dict(derived.constants) if derived else {},
        accumulates=derived.accumulates if derived else False,
        own=list(keys),
        mine=derived is not None and "formula" in keys and channel.name not in shipped().derived,
        writable=parameter is not None and not parameter.is_flag,
    )
