"""What is wrong with a request's fields, in both languages: the library's own words are English."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from mikas.i18n import Text

_WHAT = {
    "missing": Text("is missing", "не указано"),
    "extra_forbidden": Text("is not known here", "здесь не бывает"),
    "json_invalid": Text("is no JSON", "не является JSON"),
    "literal_error": Text("has to be one of: {expected}", "бывает только: {expected}"),
    "enum": Text("has to be one of: {expected}", "бывает только: {expected}"),
    "union_tag_invalid": Text(
        "has to be one of: {expected_tags}", "бывает только: {expected_tags}"
    ),
    "union_tag_not_found": Text("does not say its {discriminator}", "не указано: {discriminator}"),
    "greater_than": Text("has to be more than {gt}", "должно быть больше {gt}"),
    "greater_than_equal": Text("has to be {ge} or more", "должно быть не меньше {ge}"),
    "less_than": Text("has to be less than {lt}", "должно быть меньше {lt}"),
    "less_than_equal": Text("has to be {le} or less", "должно быть не больше {le}"),
    "string_too_short": Text(
        "is too short (at least {min_length})", "слишком коротко (не меньше {min_length})"
    ),
    "string_too_long": Text(
        "is too long (at most {max_length})", "слишком длинно (не больше {max_length})"
    ),
    "too_short": Text("has too few items (at least {min_length})", "слишком мало ({min_length})"),
    "too_long": Text("has too many items (at most {max_length})", "слишком много ({max_length})"),
    "string_pattern_mismatch": Text(
        "is not written as it should be ({pattern})", "записано не так, как нужно ({pattern})"
    ),
}
_KINDS = {
    "int": Text("has to be a whole number", "должно быть целым числом"),
    "float": Text("has to be a number", "должно быть числом"),
    "finite": Text("has to be a finite number", "должно быть конечным числом"),
    "bool": Text("has to be true or false", "должно быть true или false"),
    "string": Text("has to be a text", "должно быть текстом"),
    "list": Text("has to be a list", "должно быть списком"),
    "dict": Text("has to be an object", "должно быть объектом"),
    "model": Text("has to be an object", "должно быть объектом"),
}
_OTHER = Text("is not as it should be", "имеет недопустимое значение")


def told(error: Mapping[str, Any]) -> Text:
    """The field's name and what is wrong with it; `error`: one of pydantic's."""
    kind = str(error["type"])
    what = _WHAT.get(kind) or _KINDS.get(kind.partition("_")[0]) or _OTHER
    try:
        what = what.filled(**error.get("ctx", {}))
    except (KeyError, IndexError):
        what = _OTHER
    where = _name(error["loc"])
    return Text(f"“{where}” {what.en}", f"«{where}» {what.ru}")


def _name(where: Sequence[str | int]) -> str:
    """`wanted.3.name`, without the word for where a request keeps it."""
    return ".".join(map(str, where[1:])) or str(where[0] if where else "?")
