"""Texts of validation errors: in both languages, with the name of the field."""

from __future__ import annotations

import re

import pytest
from pydantic import TypeAdapter, ValidationError

from mikas.dashboard.api.catalog import Preset
from mikas.dashboard.api.changes import WriteParameterRequest
from mikas.dashboard.api.errors import validation_text
from mikas.dashboard.api.library.dumps import DumpRequest


def errors_of(kind, value):
    with pytest.raises(ValidationError) as caught:
        TypeAdapter(kind).validate_python(value)
    return [
        validation_text(error | {"loc": ("body", *error["loc"])}) for error in caught.value.errors()
    ]


@pytest.mark.parametrize(
    ("kind", "value"),
    [(WriteParameterRequest, {}), (WriteParameterRequest, {"kind": "x", "name": 3}),
     (WriteParameterRequest, 3), (Preset, {"name": 3}),
     (DumpRequest, {"space": "rom", "first": -1, "last": "x"}),
     (list[int], "x"), (int, 1.5), (bool, "maybe")],
)  # fmt: skip
def test_every_validation_error_has_a_text_in_both_languages(kind, value) -> None:
    for text in errors_of(kind, value):
        assert not re.search("[А-яЁё]", text.en), text
        assert re.search("[А-яЁё]", text.ru), text
        assert not re.search("[{}]|Input|Field", text.en + text.ru), text


def test_a_validation_error_names_its_field() -> None:
    (text, *_) = errors_of(WriteParameterRequest, {"kind": "write_parameter"})
    assert text == ("“name” is missing", "«name» не указано")


def test_an_unknown_validation_error_has_a_text_too() -> None:
    text = validation_text({"type": "something_new", "loc": ("query",), "msg": "English"})
    assert text.en == "“query” has an invalid value"
