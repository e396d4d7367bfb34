"""Each public name states its types; the list of public modules is that of the reference."""

from __future__ import annotations

import inspect
from importlib import import_module

import pytest
from tools.docs.generated.python_pages import PAGES
from tools.public_types import LEAST, causes, completeness, public_names

# A module here is kept as the library's interface: it changes only by addition.
PUBLIC_MODULES = [
    "mikas",
    "mikas.catalog",
    "mikas.client",
    "mikas.client.identity",
    "mikas.commands",
    "mikas.drives",
    "mikas.errors",
    "mikas.foreign_logs",
    "mikas.framing",
    "mikas.i18n",
    "mikas.instruments",
    "mikas.link",
    "mikas.notebook.drawing",
    "mikas.recording.export",
    "mikas.recording.export.sheet",
    "mikas.recording.recorder",
    "mikas.recording.table.channels",
    "mikas.sampling.events",
    "mikas.sampling.plan",
    "mikas.survey",
    "mikas.testing",
    "mikas.testing.plugin",
]
NAMES = [name for page in PAGES for name in page.names]


def test_the_public_modules_are_these():
    assert sorted(page.name for page in PAGES) == PUBLIC_MODULES
    for name in PUBLIC_MODULES:
        assert import_module(name).__doc__
        assert not any(part.startswith("_") for part in name.split("."))


def functions_of(value):
    """The functions and properties that are written in a class, or the function itself."""
    if not inspect.isclass(value):
        return {"": value} if inspect.isfunction(value) else {}
    found = {}
    for name, each in vars(value).items():
        if name.startswith("_") and name != "__init__":
            continue
        function = getattr(each, "__func__", getattr(each, "func", getattr(each, "fget", each)))
        if inspect.isfunction(function) and function.__module__.startswith("mikas"):
            found[f".{name}"] = function
    return found


@pytest.mark.parametrize("name", NAMES, ids=lambda each: f"{each.module}.{each.name}")
def test_each_argument_and_result_of_a_public_name_has_a_type(name):
    for method, function in functions_of(name.value).items():
        signature = inspect.signature(function, follow_wrapped=True)
        for place, argument in enumerate(signature.parameters.values()):
            is_self = place == 0 and method
            assert is_self or argument.annotation is not argument.empty, f"{method}({argument})"
        assert signature.return_annotation is not signature.empty, method


def symbol(name, *, known=True, ambiguous=False, exported=True):
    return {
        "name": name, "isTypeKnown": known, "isTypeAmbiguous": ambiguous, "isExported": exported,
    }  # fmt: skip


def test_a_public_name_without_a_type_is_named():
    assert {"mikas.connect", "mikas.client.connecting.connect"} <= public_names()
    public = {"mikas.errors.base.MikasError"}
    known = [symbol(f"mikas.x{n}") for n in range(998)]
    found = completeness([*known, symbol("mikas.errors.base.MikasError.what", known=False)], public)
    assert found.unknown == ("mikas.errors.base.MikasError.what",)
    assert found.share == pytest.approx(998 / 999)
    assert not found.suffices
    private = symbol("mikas.errors.base.MikasError._what", ambiguous=True)
    assert completeness([*known, private, symbol("mikas.y", known=False)], public).suffices
    hidden = symbol("mikas.errors.base.MikasError.what", known=False, exported=False)
    assert completeness([*known, hidden], public).share == 1


def test_a_cause_is_a_name_that_is_unknown_by_itself():
    unknown = symbol("mikas.x", known=False) | {
        "diagnostics": [{"message": "Type annotation is\n  missing"}]
    }
    made_of_it = symbol("mikas.y", known=False) | {
        "diagnostics": [{"message": "Return type is partially unknown"}]
    }
    assert list(causes([unknown, made_of_it])) == ["mikas.x: Type annotation is missing"]


def test_too_many_names_without_a_type_are_too_many():
    half = [symbol("mikas.x"), symbol("mikas.y", ambiguous=True)]
    assert completeness(half, ()).share == 0.5 < LEAST
    assert not completeness(half, ()).suffices
    assert not completeness([], ()).suffices
