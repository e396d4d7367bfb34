"""Routes that change the user's own catalog: keys of any channel, derived channels of their own.

A change is in use at once: the running connection, recordings and all pages have it.
"""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Query
from pydantic import BaseModel, Field

from mikas.catalog import Level
from mikas.catalog.own import changes
from mikas.dashboard.api.catalog import CatalogResponse, catalog_of
from mikas.dashboard.api.dependencies import Controller, Line, TheDashboard, Words
from mikas.dashboard.api.errors import errors
from mikas.dashboard.errors import NotFound

router = APIRouter(tags=["channels"])

Name = Annotated[str, Field(min_length=1, max_length=40)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
Ends = tuple[Finite, Finite]
OldVersion = Annotated[str | None, Query(max_length=300)]
Version = Annotated[
    str | None, Field(max_length=300, description="of the catalog that was shown; null: any")
]


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
    keys: dict[str, Any] = {
        key: value for key, value in body.model_dump().items() if key in body.model_fields_set
    }
    keys.pop("version", None)
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
