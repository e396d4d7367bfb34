"""Presets: pages of tiles as data. Those that come with the program, and the user's own."""

from __future__ import annotations

import json
import tomllib
from functools import cache
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, Field, TypeAdapter, ValidationError

from mikas.dashboard.api.errors import TwoTexts
from mikas.errors import UsageError, reason_at

_SHIPPED = Path(__file__).with_name("presets.toml")
Name = Annotated[str, Field(min_length=1, max_length=40)]


class Tile(BaseModel):
    """One tile. `names`: its channels; a table without any has them all."""

    kind: Literal["gauge", "number", "lamp", "strip", "table"]
    names: list[Name] = Field(max_length=100)
    span: int = Field(1, ge=1, le=3)


class Preset(BaseModel):
    """One page of tiles."""

    id: str = Field(pattern=r"^[A-Za-z0-9_-]{1,64}$")
    name: TwoTexts
    shipped: bool = False
    tiles: list[Tile] = Field(max_length=200)


Presets = TypeAdapter(list[Preset])


@cache
def shipped() -> tuple[Preset, ...]:
    """Those that come with the program."""
    stored = tomllib.loads(_SHIPPED.read_text("utf-8"))["preset"]
    return tuple(Preset(**{**preset, "shipped": True}) for preset in stored)


def own(file: Path) -> list[Preset]:
    """The user's; a file that can't be read, or holds something else, counts as none."""
    try:
        return Presets.validate_json(file.read_bytes())
    except (OSError, ValidationError):
        return []


def keep(file: Path, presets: list[Preset]) -> None:
    """Keeps the user's presets, all or nothing. Raises `UsageError`."""
    told = [{**preset.model_dump(), "shipped": False} for preset in presets]
    fresh = file.with_suffix(".new")
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        fresh.write_text(json.dumps(told, ensure_ascii=False, indent=1), "utf-8")
        fresh.replace(file)
    except OSError as error:
        raise UsageError(problem=reason_at(file, error)) from error
