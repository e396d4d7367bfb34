"""Values as JSON: texts in both languages, enums by their value, dataclasses by their fields."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Any

from mikas.i18n import Text


def json_of(value: object) -> Any:  # noqa: ANN401  (JSON)
    """Return `value` as JSON values. Another kind of value stays as it is."""
    match value:
        case Text():
            return value._asdict()
        case Enum():
            return value.value
        case Mapping():
            return {key: json_of(each) for key, each in value.items()}
        case tuple() | list():
            return [json_of(each) for each in value]
    if is_dataclass(value):
        return picked(value, *(each.name for each in fields(value)))
    return value


def picked(value: object, *names: str) -> dict[str, Any]:
    """Return these attributes of `value` as JSON values, by name."""
    return {name: json_of(getattr(value, name)) for name in names}
