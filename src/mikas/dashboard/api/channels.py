"""Routes of channels: changes of the user's own catalog, single values, a formula being typed.

Changed are keys of any channel, and derived channels of the user's own. A change is in use at once:
the running connection, recordings and all pages have it.

Live, values come from the last minutes, of a recording from its file, at any moment of either.
Bytes are those of the reading itself, or computed back from the value, which is exact: the loader
refuses conversions that do not give every raw value back. A flag, which shares its byte, has none
then.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Annotated, Any, Final

from fastapi import APIRouter, Query
from pydantic import BaseModel, Field

from mikas.catalog import Catalog, Derived, Level, Parameter
from mikas.catalog.formula_syntax import Parsed, parse
from mikas.catalog.formulas import Calculation
from mikas.catalog.loading.build import does_not_exist
from mikas.catalog.lookup import is_corrected
from mikas.catalog.model import in_order
from mikas.catalog.own import changes
from mikas.catalog.undecided import values_otherwise
from mikas.client import Reading
from mikas.dashboard.api.catalog import CatalogResponse, catalog_of
from mikas.dashboard.api.dependencies import (
    Controller,
    KnownClient,
    Line,
    TheDashboard,
    TheRequester,
    Words,
)
from mikas.dashboard.api.errors import TwoTexts, errors, made_of, two
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.errors import NotFound, api_hex
from mikas.dashboard.library.folder import RecordingFile
from mikas.errors import FormulaError, UnknownParameter, ValueDoesNotFit
from mikas.i18n import Text
from mikas.recording.table.channels import Rows
from mikas.sampling.events import LineState

router: Final = APIRouter(prefix="/api", tags=["channels"])

Name = Annotated[str, Field(min_length=1, max_length=40)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
Ends = tuple[Finite, Finite]
OldVersion = Annotated[str | None, Query(max_length=300)]
Version = Annotated[
    str | None, Field(max_length=300, description="of the catalog that was shown; null: any")
]
_REACH = 15.0
"""Seconds: an older value is not one of this moment."""

_ROUNDED = 1e-6
"""Seconds by which the time of a row may have become earlier in JSON."""

At = Annotated[
    float | None,
    Query(allow_inf_nan=False, description="UNIX seconds; null: now, a recording's end"),
]
Moments = Mapping[str, tuple[float, float]]
"""By channel: the time and value of its last one."""


class NewLimits(BaseModel):
    """Limits of alarms; null: no such limit, also where the shipped catalog has one."""

    danger_low: Finite | None = None
    warning_low: Finite | None = None
    warning_high: Finite | None = None
    danger_high: Finite | None = None
    hysteresis: Annotated[Finite, Field(ge=0)] = 0
    when_true: Level = Level.NONE


class KeysRequest(BaseModel):
    """The keys to change; a key that is not named stays, null resets it to the shipped one."""

    version: Version = None
    limits: NewLimits | None = None
    gauge: Ends | None = None
    reference: Ends | None = None
    span_least: Annotated[Finite, Field(gt=0)] | None = None


class NewText(BaseModel):
    """A text in both languages."""

    en: Annotated[Line, Field(min_length=1, max_length=200)]
    ru: Annotated[Line, Field(min_length=1, max_length=200)]


class FormulaRequest(BaseModel):
    """A formula with its constants."""

    formula: Words = Field(max_length=1000, examples=["100 * JAIR / full"])
    constants: Annotated[dict[Name, Finite], Field(max_length=50, examples=[{"full": 385}])] = {}


class ChannelRequest(FormulaRequest):
    """A derived channel. `new`: the name must not be in use."""

    version: Version = None
    new: bool = False
    text: NewText
    unit: Annotated[Line, Field(max_length=40)] = ""
    decimals: Annotated[int, Field(ge=0, le=6)] = 2
    accumulates: bool = False
    limits: NewLimits | None = None


@router.put("/channels/{name}/keys", responses=errors(404, 409))
def change_keys(
    dashboard: TheDashboard, _: Controller, name: str, body: KeysRequest
) -> CatalogResponse:
    """Set limits, gauge, reference or least span of a channel in the user's own catalog."""
    given = body.model_dump(exclude={"version"}).items()
    keys: dict[str, Any] = {key: value for key, value in given if key in body.model_fields_set}
    dashboard.catalogs.change(
        body.version, lambda own, known: changes.set_keys(own, known, name, keys)
    )
    return catalog_of(dashboard)


@router.delete("/channels/{name}/keys", responses=errors(404, 409))
def reset_keys(
    dashboard: TheDashboard,
    _: Controller,
    name: str,
    keys: Annotated[str, Query(max_length=100, description="A,B; all of them if missing")] = "",
    version: OldVersion = None,
) -> CatalogResponse:
    """Make keys of a channel as shipped again."""
    named = [key for key in keys.split(",") if key] or changes.KEYS
    if unknown := set(named).difference(changes.KEYS):
        raise NotFound(name=", ".join(sorted(unknown)))
    dashboard.catalogs.change(
        version, lambda own, known: changes.reset_keys(own, known, name, named)
    )
    return catalog_of(dashboard)


@router.put("/channels/{name}", responses=errors(409))
def change_channel(
    dashboard: TheDashboard, _: Controller, name: str, body: ChannelRequest
) -> CatalogResponse:
    """Add a derived channel to the user's own catalog, or change one. It is sampled at once."""
    keys: dict[str, Any] = body.model_dump(exclude={"version", "new"})
    keys |= {"unit": body.unit or None, "accumulates": body.accumulates or None}
    dashboard.catalogs.change(
        body.version,
        lambda own, known: changes.set_channel(own, known, name, keys, new=body.new),
    )
    return catalog_of(dashboard)


@router.delete("/channels/{name}", responses=errors(409))
def delete_channel(
    dashboard: TheDashboard, _: Controller, name: str, version: OldVersion = None
) -> CatalogResponse:
    """Delete a derived channel from the user's own catalog."""
    dashboard.catalogs.change(version, lambda own, known: changes.remove_channel(own, known, name))
    return catalog_of(dashboard)


class ChannelValue(BaseModel):
    """A channel at a moment. All null: it has no value then."""

    name: str
    value: float | None = None
    time: float | None = None
    raw: Annotated[
        str | None, Field(description="hex, low byte first; null: unknown, or computed")
    ] = None
    interpretation: Annotated[str | None, Field(description="that decoded it")] = None
    otherwise: Annotated[
        dict[str, float],
        Field(description="by the other interpretations that only a car decides on (E3)"),
    ] = {}


class TrialRequest(FormulaRequest):
    """A formula to compute; `recording` null: live. `name`: of the channel that it will be."""

    name: Annotated[str, Field(max_length=40)] = ""
    recording: Annotated[str | None, Field(max_length=300)] = None
    at: Annotated[
        Finite | None, Field(description="UNIX seconds; null: now, a recording's end")
    ] = None


class TrialInput(BaseModel):
    """A channel of the formula at that moment."""

    name: str
    value: float | None


class TrialResponse(BaseModel):
    """The formula's value, or its problem. Both null: a channel has no value, or the formula none.

    `span`: the first and the next character of the wrong part; null: the whole formula.
    """

    value: float | None = None
    problem: TwoTexts | None = None
    span: tuple[int, int] | None = None
    inputs: list[TrialInput] = []


@router.get("/channels/{name}/value", responses=errors(404, 409, 504))
async def value(
    requester: TheRequester,
    name: str,
    recording: Annotated[str | None, Query(max_length=300)] = None,
    at: At = None,
) -> ChannelValue:
    """Return a channel's value at a moment with its bytes, live or in a recording."""
    dashboard = requester.dashboard
    channel = await _channel(requester, name, recording)
    if recording is None and at is None and isinstance(channel, Parameter):
        return _now(dashboard, channel.name)
    name = name if channel is None else channel.name
    moments = await _moments(requester, [name], recording, at)
    if (found := moments.get(name)) is None:
        return ChannelValue(name=name)
    time, number = found
    answer = ChannelValue(name=name, value=number, time=time)
    if isinstance(channel, Parameter):
        answer.interpretation = dashboard.library.interpretation
        raw = _raw(channel, number, answer.interpretation)
        if raw is not None:
            answer.raw = raw.hex().upper()
            answer.otherwise = values_otherwise(channel, raw, answer.interpretation)
    return answer


@router.post("/channels/try", responses=errors(404, 409, 504))
async def try_formula(requester: TheRequester, _: KnownClient, body: TrialRequest) -> TrialResponse:
    """Compute a formula at a moment, live or in a recording, without keeping it."""
    known = requester.dashboard.catalog
    try:
        parsed = _parsed(known, body)
    except FormulaError as error:
        return TrialResponse(problem=two(error.problem), span=error.span)
    corrected = [
        name
        for name in parsed.inputs
        if name not in known.channels
        or is_corrected(known.channel(name), requester.library.interpretation)
    ]
    moments = await _moments(requester, corrected, body.recording, body.at)
    inputs = {name: moments[name][1] for name in parsed.inputs if name in moments}
    number = Calculation(parsed).number(inputs) if len(inputs) == len(parsed.inputs) else None
    return TrialResponse(
        value=number if number is not None and isfinite(number) else None,
        inputs=[TrialInput(name=name, value=inputs.get(name)) for name in parsed.inputs],
    )


async def _channel(
    requester: TheRequester, name: str, recording: str | None
) -> Parameter | Derived | None:
    """Return a channel of the unit; None: an instrument's, now or in the recording.

    Raises `UnknownParameter`.
    """
    dashboard = requester.dashboard
    beside = {each.name for each in dashboard.instruments.channels}
    if name in beside or name in dashboard.catalog.instruments:
        return None
    try:
        return dashboard.catalog.channel(name)
    except UnknownParameter:
        opened = requester.library.opened
        if recording is None or not await requester.view(
            recording, lambda file: name in opened(file).instrument_channels
        ):
            raise
        return None


def _parsed(known: Catalog, body: TrialRequest) -> Parsed:
    """Return the formula. Raises `FormulaError`, also for a channel that does not exist."""
    parsed = parse(body.formula, body.constants, known.input_of)
    for name, span in zip(parsed.inputs, parsed.places, strict=True):
        if name not in known.formula_channels:
            raise FormulaError(
                does_not_exist(name, (*known.formula_channels, *body.constants)), span
            )
        needed = in_order(known.derived, [name]) if name in known.derived else ()
        if body.name.upper() in {each.name for each in needed}:
            raise FormulaError(
                Text(f"needs {name}, which needs this channel", f"замкнут в круг: {name}"), span
            )
    return parsed


def _now(dashboard: Dashboard, parameter: str) -> ChannelValue:
    """Return the latest reading, with its own bytes."""
    monitor = dashboard.monitor
    with monitor.lock:
        is_sampled = monitor.line is LineState.SAMPLING
        reading = monitor.latest.get(parameter) if is_sampled else None
    if not isinstance(reading, Reading) or dashboard.connection.now() - reading.time > _REACH:
        return ChannelValue(name=parameter)
    return made_of(
        ChannelValue,
        reading,
        name=parameter,
        time=reading.time + dashboard.connection.later,
        value=float(reading.value),
        raw=api_hex(reading.raw),
        otherwise=values_otherwise(reading.parameter, reading.raw, reading.interpretation),
    )


async def _moments(
    requester: TheRequester, names: Sequence[str], recording: str | None, at: float | None
) -> Moments:
    if recording is None:
        return await requester.compute(lambda: _live(requester.dashboard, names, at))

    def look(file: RecordingFile) -> Moments:
        opened = requester.library.opened(file)
        known = {each.name for each in opened.channels}
        wanted = [name for name in names if name in known]
        span = opened.span if wanted else None
        if span is None:
            return {}
        end = span[1] if at is None else at
        rows, _ = opened.window(end - _REACH, end + _ROUNDED, 20_000, wanted)
        return _last_values(rows, end)

    return await requester.view(recording, look)


def _live(dashboard: Dashboard, names: Sequence[str], at: float | None) -> Moments:
    """Return the values that are shown now, or were at `at`; none without a connection now."""
    now, later = dashboard.connection.now(), dashboard.connection.later
    if at is None and dashboard.monitor.line is not LineState.SAMPLING:
        return {}
    end = now if at is None else at - later
    found = _last_values(dashboard.history.rows(max(0.0, now - end) + _REACH, names), end)
    return {name: (time + later, value) for name, (time, value) in found.items()}


def _last_values(rows: Rows, end: float) -> Moments:
    """Return the last value of each column in the seconds up to `end`."""
    import numpy as np

    times = np.asarray(rows.times)
    end += _ROUNDED
    chosen = (times <= end) & (times >= end - _REACH)
    found = {}
    for name, column in rows.values.items():
        at = np.flatnonzero(chosen & np.isfinite(np.asarray(column)))
        if len(at):
            found[name] = float(times[at[-1]]), float(column[at[-1]])
    return found


def _raw(channel: Parameter, number: float, interpretation: str) -> bytes | None:
    if channel.is_flag:
        return None
    try:
        raw = channel.encode(number, interpretation)
    except (ValueDoesNotFit, UnknownParameter):
        return None
    return raw if channel.decode(raw, interpretation) == number else None
