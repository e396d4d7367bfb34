"""A channel of the catalog, as a client gets it: its models, and how they are filled."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Final, Literal

from pydantic import BaseModel, Field

from mikas.catalog import (
    Catalog,
    Confidence,
    Derived,
    InstrumentChannel,
    Level,
    Parameter,
    shipped,
)
from mikas.catalog.evidence import Agreement
from mikas.catalog.grounds import parameter_grounds
from mikas.dashboard.api.errors import OptionalTexts, TwoTexts, made_of


class ChannelLimits(BaseModel):
    """The limits of a channel; a value beyond one is an alarm."""

    danger_low: float | None
    warning_low: float | None
    warning_high: float | None
    danger_high: float | None
    hysteresis: Annotated[float, Field(description="how far inside a limit its alarm ends")] = 0


class LampTexts(BaseModel):
    """The texts of a flag's lamp."""

    on: TwoTexts
    off: TwoTexts
    trouble: Level = Field(description="its colour while on; that is no alarm")


class ChannelErratum(BaseModel):
    """An erratum of the source that concerns this channel."""

    id: str
    text: TwoTexts


class OtherReading(BaseModel):
    """Another interpretation of a channel's bytes, which the program can be started with."""

    name: str = Field(examples=["literal", "alternative", "family"])
    formula: str
    unit: TwoTexts


class UnitSighting(BaseModel):
    """What a unit that was met has shown of a parameter."""

    unit: str = Field(description="its model and a date")
    agreement: Agreement
    text: TwoTexts


class ChannelEvidence(BaseModel):
    """What a parameter of the protocol rests on; null: nothing, or none was met."""

    source: TwoTexts = Field(description="what the protocol's source says")
    siblings: OptionalTexts = Field(description="what sibling units and other texts say")
    sightings: list[UnitSighting]


class ChannelMeaning(BaseModel):
    """Causes of a value below or above the reference, and what to check; null: unknown."""

    low: OptionalTexts
    high: OptionalTexts
    confidence: Confidence


class ChannelInfo(BaseModel):
    """A parameter, a derived channel (`inputs`; no code and no size), or one of an instrument.

    `own`: the keys that the user's own catalog sets; `mine`: the whole channel is defined there.
    """

    name: str
    derived: bool
    instrument: bool = Field(description="an instrument beside the unit gives it")
    flag: bool
    code: int | None
    size: int | None
    unit: TwoTexts
    unit_key: str = Field(description="as in the catalog's `units`; else the text itself")
    text: TwoTexts
    short: TwoTexts = Field(description="the text of a small tile")
    names: list[str] = Field(description="other names that people use, in small letters")
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
    otherwise: list[OtherReading] = Field(description="where the source is doubtful")
    confidence: Confidence
    source: str
    evidence: ChannelEvidence | None = Field(description="of a parameter of the protocol")
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


_NO_PARAMETER: Final[dict[str, object]] = {
    "derived": True, "instrument": False, "writable": False, "code": None, "size": None,
    "range": None, "reference": None, "reference_confidence": Confidence.UNKNOWN,
    "range_kind": "", "lamp": None, "meaning": None, "errata": [], "otherwise": [],
    "evidence": None,
}  # fmt: skip
_NOT_DERIVED: Final[dict[str, object]] = {
    "derived": False, "instrument": False, "mine": False, "inputs": None, "constants": {},
    "accumulates": False,
}  # fmt: skip


def channel_info(known: Catalog, channel: Parameter | Derived, own: Entries) -> ChannelInfo:
    """Return a channel of the catalog; `own`: the entries of the own file."""
    limits = channel.alarm_limits
    if isinstance(channel, Derived):
        keys = own.get(("derived", channel.name), {})
        mine = "formula" in keys and channel.name not in shipped().derived
        special = _NO_PARAMETER | {"mine": mine, "constants": dict(channel.constants)}
    else:
        keys = own.get(("parameter", channel.name), {})
        grounds = parameter_grounds(channel)
        special = _NOT_DERIVED | {
            "evidence": grounds if channel.source != grounds.source.en else None,
            "writable": not channel.is_flag,
            "formula": channel.formula(),
            "errata": [{"id": it, "text": known.errata[it].reason} for it in channel.errata],
            "otherwise": [
                {"name": name, "formula": each.formula, "unit": each.unit_text}
                for name, each in channel.interpretations.items()
                if each != channel.conversion
            ],
        }
    return made_of(
        ChannelInfo,
        channel,
        flag=channel.is_flag,
        names=known.other_names.get(channel.name, []),
        unit=channel.unit_text,
        unit_key=channel.unit,
        gauge=channel.gauge_scale,
        span_least=channel.least_span,
        limits=limits if limits and limits.for_number else None,
        alarm_when_true=limits.when_true if limits else Level.NONE,
        own=list(keys),
        **special,
    )


def instrument_channel_info(channel: InstrumentChannel, own: Entries) -> ChannelInfo:
    """Return a channel of an instrument beside the unit; `own`: as of `channel_info`."""
    limits = channel.alarm_limits
    return made_of(
        ChannelInfo,
        channel,
        **_NO_PARAMETER
        | _NOT_DERIVED
        | {
            "instrument": True,
            "range": channel.range,
            "range_kind": "plausible" if channel.range else "",
            "formula": "",
        },
        flag=channel.is_flag,
        short=channel.short if channel.short.en else channel.text,
        names=[],
        unit=channel.unit_text,
        unit_key=channel.unit,
        limits=limits if limits and limits.for_number else None,
        alarm_when_true=Level.NONE,
        own=list(own.get(("instrument", channel.name), {})),
    )
