"""The public interface, pinned: names change only by addition, and importing them is cheap."""

from __future__ import annotations

import subprocess
import sys
from inspect import signature
from string import Formatter

import pytest

import mikas
import mikas.client
from mikas import errors

TREE = {
    "MikasError": ("Exception", Exception),
    "UsageError": ("MikasError", ValueError),
    "UnknownParameter": ("UsageError", ValueError),
    "NeedsSamples": ("UsageError", ValueError),
    "NoList": ("UsageError", ValueError),
    "AddressOutOfRange": ("UsageError", ValueError),
    "ValueDoesNotFit": ("UsageError", ValueError),
    "BadPortUrl": ("UsageError", ValueError),
    "CatalogError": ("UsageError", ValueError),
    "FormulaError": ("UsageError", ValueError),
    "CaptureError": ("UsageError", ValueError),
    "DiskFull": ("CaptureError", OSError),
    "ExportError": ("UsageError", ValueError),
    "ForeignLogError": ("UsageError", ValueError),
    "FleetError": ("UsageError", ValueError),
    "JournalError": ("UsageError", ValueError),
    "MissingExtra": ("UsageError", ImportError),
    "NoConnection": ("MikasError", ConnectionError),
    "PortNotFound": ("NoConnection", FileNotFoundError),
    "NoPortGiven": ("PortNotFound", ConnectionError),
    "AnotherAdapter": ("PortNotFound", ConnectionError),
    "AdapterTaken": ("PortNotFound", ConnectionError),
    "TakenByBrltty": ("AdapterTaken", ConnectionError),
    "AdapterWithoutDriver": ("PortNotFound", ConnectionError),
    "PortBusy": ("NoConnection", ConnectionError),
    "PortProbed": ("PortBusy", ConnectionError),
    "PortDenied": ("NoConnection", PermissionError),
    "PortFailed": ("NoConnection", ConnectionError),
    "LinkLost": ("NoConnection", ConnectionError),
    "LinkClosed": ("LinkLost", ConnectionError),
    "ConnectionSilent": ("LinkLost", ConnectionError),
    "OtherService": ("LinkLost", ConnectionError),
    "PortTaken": ("PortBusy", ConnectionError),
    "LineFlooded": ("LinkLost", ConnectionError),
    "RecordingOver": ("LinkLost", ConnectionError),
    "NoEcho": ("NoConnection", TimeoutError),
    "EchoOnly": ("NoConnection", TimeoutError),
    "NotAKLineAdapter": ("NoConnection", ConnectionError),
    "NoBroker": ("NoConnection", ConnectionError),
    "BrokerNotFound": ("NoBroker", ConnectionError),
    "BrokerUnreachable": ("NoBroker", ConnectionError),
    "BrokerRefused": ("NoBroker", ConnectionError),
    "BrokerNotTrusted": ("NoBroker", ConnectionError),
    "BrokerLost": ("NoBroker", ConnectionError),
    "LineError": ("MikasError", Exception),
    "NoResponse": ("LineError", TimeoutError),
    "DeadlinePassed": ("MikasError", TimeoutError),
    "EngineStopped": ("NoResponse", TimeoutError),
    "AnswersLate": ("LineError", Exception),
    "EchoDiffers": ("LineError", Exception),
    "WrongEchoSetting": ("EchoDiffers", Exception),
    "EchoTwice": ("EchoDiffers", Exception),
    "DamagedResponse": ("LineError", Exception),
    "WrongLength": ("LineError", Exception),
    "WrongAddress": ("LineError", Exception),
    "WrongContent": ("LineError", Exception),
    "LineNotQuiet": ("LineError", Exception),
    "ReadingSuspended": ("LineError", Exception),
    "SyncLost": ("LineError", Exception),
    "EcuRefused": ("MikasError", Exception),
    "WriteRefused": ("EcuRefused", Exception),
    "NotSupported": ("EcuRefused", Exception),
    "ListLost": ("NotSupported", Exception),
    "ReadBackDiffers": ("EcuRefused", Exception),
    "NotConfirmed": ("MikasError", Exception),
}
# These stand for a whole branch, or carry what to try in their own words.
WITHOUT_ADVICE = {
    "MikasError", "UsageError", "CaptureError", "ForeignLogError", "FormulaError", "NoConnection",
    "EcuRefused",
}  # fmt: skip

HEAVY = {"numpy", "pandas", "rich", "click", "serial", "asyncio", "sqlite3", "pyarrow", "starlette",
         "hypothesis", "platformdirs", "concurrent.futures", "tomllib", "logging"}  # fmt: skip


def own_errors():
    found = {"MikasError": errors.MikasError}
    waiting = [errors.MikasError]
    while waiting:
        for error in waiting.pop().__subclasses__():
            made = error.__name__ == error.__bases__[0].__name__  # an OSError as well
            if error.__module__.startswith("mikas.errors.") and not made:
                found[error.__name__] = error
                waiting.append(error)
    return found


def test_the_package_exports_exactly_this_list():
    assert mikas.__all__ == [
        "AsyncEcu",
        "AsyncSession",
        "Change",
        "DerivedValue",
        "Ecu",
        "Fault",
        "ForeignLog",
        "Info",
        "MikasError",
        "Parameter",
        "Passport",
        "Reading",
        "Recording",
        "Sample",
        "Session",
        "async_session",
        "connect",
        "errors",
        "open_log",
        "session",
    ]
    for name in (*mikas.__all__, "open"):
        assert getattr(mikas, name).__doc__
    assert dir(mikas) == sorted([*mikas.__all__, "__version__", "open"])
    assert mikas.__version__[0].isdigit()
    assert mikas.Ecu is mikas.client.Ecu
    assert mikas.MikasError is errors.MikasError


def test_a_misspelt_name_is_an_error_with_the_nearest_one():
    with pytest.raises(AttributeError, match=r"'conect'. Did you mean connect\?"):
        _ = mikas.conect
    with pytest.raises(AttributeError, match=r"'nonsense'$"):
        _ = mikas.nonsense
    assert not hasattr(mikas, "__wrapped__")
    with pytest.raises(ImportError, match="Recordin"):
        exec("from mikas import Recordin")


def test_import_star_leaves_the_built_in_open():
    names: dict[str, object] = {}
    exec("from mikas import *", names)
    assert set(mikas.__all__) <= set(names)
    assert "open" not in names


def test_the_async_connect_has_the_options_of_connect():
    awaited, plain = signature(mikas.AsyncEcu.connect), signature(mikas.connect)
    assert awaited.parameters == plain.parameters
    assert (awaited.return_annotation, plain.return_annotation) == ("AsyncEcu", "Ecu")


def test_the_async_methods_say_what_they_return():
    returned = {
        name: signature(getattr(mikas.AsyncEcu, name)).return_annotation
        for name in ("read", "watch", "supported", "close")
    }
    assert returned == {
        "read": "Awaitable[dict[str, Reading | DerivedValue]]",
        "watch": "AsyncItems[Sample]",
        "supported": "AsyncItems[Support]",
        "close": "None",
    }


def test_the_client_exports_exactly_this_list():
    assert mikas.client.__all__ == [
        "METHODS",
        "Answer",
        "AsyncEcu",
        "AsyncItems",
        "AsyncMemory",
        "AsyncMemorySpace",
        "Change",
        "Confirm",
        "ConnectionOptions",
        "DerivedValue",
        "Ecu",
        "EcuRecording",
        "Erased",
        "Info",
        "Limits",
        "Memory",
        "MemorySpace",
        "Method",
        "Passport",
        "Reading",
        "Run",
        "Sample",
        "ScannedCode",
        "Support",
        "Written",
        "WrittenParameter",
        "connect",
    ]
    for name in mikas.client.__all__:
        assert getattr(mikas.client, name) is not None
    with pytest.raises(AttributeError, match="nonsense"):
        _ = mikas.client.nonsense


def test_every_public_method_says_what_it_is_for():
    for name in mikas.client.__all__:
        of = getattr(mikas.client, name)
        if isinstance(of, type):
            assert of.__doc__, name
            for member in (m for m in vars(of) if not m.startswith("_")):
                described = vars(of)[member]
                if callable(described) or isinstance(described, (property, classmethod)):
                    assert described.__doc__, f"{name}.{member}"


def test_the_errors_are_one_tree_and_each_is_the_matching_builtin():
    found = own_errors()
    assert set(found) == set(TREE)
    for name, (parent, builtin) in TREE.items():
        assert found[name].__bases__[0].__name__ == parent
        assert issubclass(found[name], builtin)
        assert getattr(errors, name) is found[name]
        assert found[name].__doc__
        if name != "MikasError":
            assert name in errors.__doc__, f"{name} is missing in the drawn tree"


def fields_of(text):
    return {name for _, name, _, _ in Formatter().parse(text) if name is not None}


@pytest.mark.parametrize("name", TREE)
def test_an_error_speaks_both_languages(name):
    error = getattr(errors, name)
    for text in (error.what, error.advice):
        assert bool(text.en) == bool(text.ru)
        assert fields_of(text.en) == fields_of(text.ru)
    assert error.what.en
    assert bool(error.advice.en) is (name not in WITHOUT_ADVICE)
    words = error.what.ru.split()
    assert any("а" <= letter <= "я" for letter in error.what.ru) or all("{" in w for w in words)


def run(code):
    done = subprocess.run(
        [sys.executable, "-I", "-c", code], capture_output=True, text=True, check=True, timeout=60
    )
    return set(done.stdout.split())


@pytest.mark.parametrize(
    ("code", "but"),
    [
        ("import mikas", ()),
        ("import mikas; mikas.errors; mikas.MikasError", ()),
        ("from mikas.client import connect", ("tomllib",)),
    ],
)
def test_importing_it_imports_nothing_heavy(code, but):
    bare = run("import sys; print(*sys.modules)")
    loaded = run(f"{code}\nimport sys; print(*sys.modules)") - bare
    assert loaded & HEAVY <= set(but)


def test_import_mikas_loads_only_itself():
    loaded = run("import mikas, sys; print(*(m for m in sys.modules if m.startswith('mikas')))")
    assert loaded == {"mikas"}
