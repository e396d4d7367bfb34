"""Each error can be copied, pickled, raised in another process, built by its documented fields."""

from __future__ import annotations

import ast
import copy
import pickle
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import pytest

import mikas
import mikas.dashboard.errors
from mikas import errors
from mikas.errors import MikasError
from mikas.i18n import Text


def family(kind=MikasError):
    yield kind
    for each in kind.__subclasses__():
        made = each.__name__ == each.__bases__[0].__name__  # by `caused_by`
        if each.__module__.startswith("mikas.") and not made:
            yield from family(each)


KINDS = sorted(set(family()), key=lambda kind: kind.__qualname__)
OWN = {  # with an `__init__` of their own
    "UnknownParameter": ("TWAX", ("TWAT",)),
    "CatalogError": ("own.toml", 3, Text("wrong", "ошибка")),
    "FormulaError": (Text("wrong", "ошибка"), (1, 2)),
    "CaptureError": ("a.pcapng", Text("cut", "обрезан"), 12),
    "ExportError": ("a.csv", Text("exists", "есть")),
    "ForeignLogError": ("a.msl", Text("not one", "не тот"), 7),
    "FleetError": ("s3://drives", Text("gone", "нет")),
    "ConfirmationOutdated": (),
}


def made(kind):
    for base in kind.__mro__:
        if base.__name__ in OWN:
            return kind(*OWN[base.__name__])
    names = kind.field_names()
    fields = {name: 3 if name in NUMBERS else Text(f"a {name}", f"{name}") for name in names}
    error = kind(**fields, request=b"\x01", received=b"", time=2.5)
    error.__cause__ = None
    return error


NUMBERS = {"seconds", "limit", "wanted", "rate", "most", "baud", "last", "count", "address"}


def same(one, other):
    assert type(one) is type(other)
    assert (str(one), one.text, one.args) == (str(other), other.text, other.args)
    assert (one.request, one.received, one.time) == (other.request, other.received, other.time)
    assert one.fields == other.fields
    assert one.has_class_advice == other.has_class_advice
    assert one.__dict__ == other.__dict__


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
class TestEach:
    def test_is_the_same_after_pickle_and_copy(self, kind):
        try:
            error = made(kind)
        except (TypeError, ValueError):
            pytest.fail(f"{kind.__name__} can't be made by its documented fields")
        for protocol in range(2, pickle.HIGHEST_PROTOCOL + 1):
            same(pickle.loads(pickle.dumps(error, protocol)), error)
        same(copy.copy(error), error)
        same(copy.deepcopy(error), error)

    def test_a_wrong_field_is_a_type_error(self, kind):
        if any(base.__name__ in OWN for base in kind.__mro__):
            with pytest.raises(TypeError):
                kind(bogus=1)
            return
        with pytest.raises(TypeError, match="bogus"):
            kind(bogus=1)


def made_in(file):
    """Yield the calls in `file` that make an error by fields, with its class."""
    of_tree = {kind.__name__: kind for kind in KINDS if kind.__init__ is MikasError.__init__}
    text = file.read_text("utf-8")
    foreign = "import click" in text or "import pytest" in text  # both have a UsageError
    for call in ast.walk(ast.parse(text)):
        if isinstance(call, ast.Call) and isinstance(call.func, ast.Name | ast.Attribute):
            is_foreign = foreign and isinstance(call.func, ast.Attribute)
            name = call.func.id if isinstance(call.func, ast.Name) else call.func.attr
            given = {keyword.arg for keyword in call.keywords}
            if name in of_tree and None not in given and not is_foreign:
                yield of_tree[name], call.lineno, given


def test_the_program_makes_each_error_of_its_fields():
    top, wrong = Path(mikas.__file__).parent, []
    for file in top.rglob("*.py"):
        for kind, line, given in made_in(file):
            needed = kind.field_names() - kind.defaults.keys() - kind.more_fields
            extra = given - kind.field_names() - {"request", "received", "time", "advice"}
            if extra or needed - given:
                wrong.append(f"{file.relative_to(top)}:{line} {kind.__name__}")
    assert not wrong


def fail(kind):
    raise made(kind)


def test_an_error_is_raised_again_from_another_process():
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as processes:
        for kind in (errors.NoEcho, errors.WrongLength, errors.CaptureError):
            with pytest.raises(kind) as caught:
                processes.submit(fail, kind).result()
            same(caught.value, made(kind))


def test_a_missing_field_is_a_type_error():
    with pytest.raises(TypeError, match="needs the field problem"):
        errors.LinkLost(url="/dev/ttyUSB0")


@pytest.mark.parametrize(
    "kind",
    [errors.NoEcho, errors.EchoOnly, errors.NoResponse, errors.ConnectionSilent,
     errors.EngineStopped, errors.DeadlinePassed],
)  # fmt: skip
def test_silence_is_a_timeout_error_whichever_step_was_silent(kind):
    assert issubclass(kind, TimeoutError)


@pytest.mark.parametrize("protocol", range(pickle.HIGHEST_PROTOCOL + 1))
def test_a_builtin_class_travels_by_every_pickle_protocol(protocol):
    error = errors.CaptureError("a.pcapng", Text("gone", "нет")).caused_by(FileNotFoundError(2, ""))
    same(error, pickle.loads(pickle.dumps(error, protocol)))


def test_an_import_error_is_no_error_of_the_system():
    error = errors.MissingExtra(feature="x", extra="y")
    assert error.caused_by(FileNotFoundError(2, "")).text == error.text
