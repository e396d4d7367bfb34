"""An error that the system has caused is also the matching `OSError`, with its number and file."""

from __future__ import annotations

import ast
import copy
import errno
import os
import pickle
from pathlib import Path

import pytest
from tests.test_errors_travel import KINDS, made, same

import mikas
from mikas import errors
from mikas.cli.failures import failure_of
from mikas.client.gate import add_to_journal
from mikas.client.memory.dumps import read_manifest
from mikas.errors import MikasError, UnfitFile, system_error
from mikas.fleet.places import errors_of, recordings_in
from mikas.i18n import Text
from mikas.link import open_link
from mikas.recording.capture.opening import capture_error, opened_capture
from mikas.recording.capture.writer import CaptureWriter
from mikas.recording.export.exporting import check_free, write_whole
from mikas.saving import save_json

BUILTINS = {
    errno.ENOENT: FileNotFoundError,
    errno.EACCES: PermissionError,
    errno.EPERM: PermissionError,
    errno.EISDIR: IsADirectoryError,
    errno.ENOTDIR: NotADirectoryError,
    errno.EEXIST: FileExistsError,
    errno.ENOSPC: OSError,
    errno.EDQUOT: OSError,
    errno.EROFS: OSError,
    errno.ETIMEDOUT: TimeoutError,
    errno.ECONNREFUSED: ConnectionRefusedError,
    errno.EPIPE: BrokenPipeError,
}
OF_NOTHING = [kind for kind in KINDS if not issubclass(kind, ImportError)]


def table():
    for kind in OF_NOTHING:
        for number, builtin in BUILTINS.items():
            yield kind, number, builtin


def test_each_error_is_the_builtin_of_its_cause_and_else_as_before():
    for kind, number, builtin in table():
        plain = made(kind)
        error = plain.caused_by(system_error(number), "a/b.bin")
        assert isinstance(error, kind)
        assert isinstance(error, builtin), (kind, number)
        assert (error.errno, error.filename) == (number, "a/b.bin")
        assert error.strerror == os.strerror(number)
        assert error.kind is kind
        assert (type(error).__name__, type(error).__module__) == (kind.__name__, kind.__module__)
        assert (str(error), repr(error), error.text) == (str(plain), repr(plain), plain.text)
        assert (error.args, error.fields, error.advice) == (plain.args, plain.fields, plain.advice)
        assert failure_of(error) == failure_of(plain)


def test_it_stays_so_after_pickle_and_copy():
    for kind, number, builtin in table():
        error = made(kind).caused_by(system_error(number), "a/b.bin")
        for other in (pickle.loads(pickle.dumps(error)), copy.copy(error), copy.deepcopy(error)):
            same(other, error)
            assert isinstance(other, builtin)
            assert (other.errno, other.filename) == (number, "a/b.bin")
            assert other.kind is kind


def test_another_cause_takes_the_place_of_the_first():
    error = errors.ExportError("a.csv", Text("x", "х")).caused_by(system_error(errno.ENOENT), "a")
    again = error.caused_by(system_error(errno.ENOSPC), "b")
    assert not isinstance(again, FileNotFoundError)
    assert (again.errno, again.filename, again.kind) == (errno.ENOSPC, "b", errors.ExportError)


def test_what_is_no_error_of_the_system_changes_nothing():
    error = errors.UsageError(problem="x")
    assert error.caused_by(ValueError("y")) is error


@pytest.mark.parametrize(
    ("kind", "number"),
    [
        (errors.PortNotFound, errno.ENOENT),
        (errors.PortDenied, errno.EACCES),
        (errors.PortBusy, errno.EBUSY),
        (errors.DiskFull, errno.ENOSPC),
        (errors.NoResponse, errno.ETIMEDOUT),
        (errors.NoEcho, errno.ETIMEDOUT),
        (errors.DeadlinePassed, errno.ETIMEDOUT),
    ],
)
def test_an_error_that_is_always_one_has_its_number(kind, number):
    assert made(kind).errno == number


# Each place that the system may refuse


def missing(folder):
    return folder / "no" / "file.pcapng"


PLACES = {
    "open": (lambda at: mikas.open(missing(at)), errors.CaptureError, FileNotFoundError),
    "open a folder": (mikas.open, errors.CaptureError, IsADirectoryError),
    "catalogs": (
        lambda at: mikas.connect("sim:", catalogs=[missing(at)]),
        errors.CatalogError,
        FileNotFoundError,
    ),
    "a folder of catalogs": (
        lambda at: mikas.connect("sim:", catalogs=[at]),
        errors.CatalogError,
        IsADirectoryError,
    ),
    "record there": (
        lambda at: CaptureWriter(at / "present", url="sim:"),
        errors.CaptureError,
        FileExistsError,
    ),
    "record nowhere": (
        lambda at: CaptureWriter(missing(at), url="sim:"),
        errors.CaptureError,
        FileNotFoundError,
    ),
    "session": (
        lambda at: mikas.session("sim:", channels=["FREQ"], record=at / "present"),
        errors.CaptureError,
        FileExistsError,
    ),
    "export there": (
        lambda at: check_free(at / "present", overwrite=False),
        errors.ExportError,
        FileExistsError,
    ),
    "export nowhere": (
        lambda at: write_whole(missing(at), lambda _: None, overwrite=False),
        errors.ExportError,
        FileNotFoundError,
    ),
    "journal": (
        lambda at: add_to_journal(at / "present" / "journal", {}),
        errors.JournalError,
        (FileExistsError, NotADirectoryError),
    ),
    "save": (
        lambda at: save_json(at / "present" / "a.json", {}),
        errors.UsageError,
        (FileExistsError, NotADirectoryError),
    ),
    "manifest": (
        lambda at: read_manifest(at / "folder"),
        errors.UsageError,
        IsADirectoryError,
    ),
    "replay": (lambda at: open_link(f"replay:{missing(at)}"), errors.MikasError, FileNotFoundError),
    "port": (lambda at: open_link(f"{at}/ttyUSB9"), errors.PortNotFound, FileNotFoundError),
}


@pytest.mark.parametrize("name", PLACES)
def test_the_error_of_a_place_is_the_systems_as_well(name, tmp_path):
    act, kind, builtin = PLACES[name]
    (tmp_path / "present").write_bytes(b"")
    (tmp_path / "folder.json").mkdir()
    with pytest.raises(kind) as caught:
        act(tmp_path)
    assert isinstance(caught.value, builtin)
    assert caught.value.errno
    assert str(tmp_path) in str(caught.value.filename)
    with pytest.raises(OSError):  # noqa: PT011  (any of them is one)
        act(tmp_path)


def test_a_dataset_that_is_a_file_is_the_systems_error(tmp_path):
    with pytest.raises(errors.FleetError) as caught, errors_of(str(tmp_path)):
        (tmp_path / "no" / "entry").read_bytes()
    assert isinstance(caught.value, FileNotFoundError)
    with pytest.raises(errors.FleetError) as caught:
        list(recordings_in(str(tmp_path / "no")))
    assert isinstance(caught.value, FileNotFoundError)
    assert caught.value.errno == errno.ENOENT


def test_a_full_disk_has_its_number():
    error = capture_error("a.pcapng", system_error(errno.ENOSPC))
    assert type(error) is errors.DiskFull
    assert (error.errno, error.filename) == (errno.ENOSPC, "a.pcapng")
    quota = capture_error("a.pcapng", system_error(errno.EDQUOT))
    assert (type(quota), quota.errno) == (errors.DiskFull, errno.EDQUOT)


def test_the_error_of_whoever_reads_a_recording_stays_his(tmp_path):
    file = tmp_path / "a.pcapng"
    CaptureWriter(file, url="sim:").close()
    inner = errors.UsageError(problem="x").caused_by(system_error(errno.EACCES), "other.csv")
    with pytest.raises(errors.UsageError) as caught, opened_capture(file):
        raise inner
    assert caught.value is inner


def test_a_file_that_is_unfit_has_the_number_and_words_of_its_reason():
    unfit = UnfitFile(errno.EISDIR, Text("a folder", "папка"))
    error = errors.UsageError(problem="x").caused_by(unfit, "d")
    assert isinstance(error, IsADirectoryError)
    assert error.strerror == "a folder"


# The kind: no place is left out

_IN_ITSELF = {"unusable_file", "capture_error", "_not_begun"}
_NO_ERROR_OF_OURS = {"UnfitFile", "ValueError", "OutputError", "KeyboardInterrupt"}
_OF_SYSTEM = ("OSError", "FileNotFoundError", "FileExistsError", "PermissionError")


def raised_from(handler: ast.ExceptHandler):
    """Yield what is raised from the error that a handler has caught."""
    for node in ast.walk(handler):
        caught = isinstance(node, ast.Raise) and isinstance(node.cause, ast.Name)
        if caught and node.cause.id == handler.name:
            yield node.exc


def is_of_system(exception: ast.expr) -> bool:
    name = exception.func if isinstance(exception, ast.Call) else exception
    if isinstance(name, ast.Attribute):
        return name.attr == "caused_by"
    return isinstance(name, ast.Name) and name.id in _IN_ITSELF | _NO_ERROR_OF_OURS


def test_no_place_turns_an_error_of_the_system_into_another_one_only():
    top = Path(mikas.__file__).parent
    left = []
    for file in top.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text("utf-8"))):
            if not isinstance(node, ast.ExceptHandler) or not node.name or node.type is None:
                continue
            if not any(name in ast.unparse(node.type) for name in _OF_SYSTEM):
                continue
            left += [
                f"{file.relative_to(top)}:{exception.lineno}"
                for exception in raised_from(node)
                if not is_of_system(exception)
            ]
    assert not left, "raise X(…).caused_by(error) from error"


def test_both_handlers_catch_it():
    for kind in (MikasError, OSError, FileNotFoundError):
        with pytest.raises(kind):
            mikas.open("no such file.pcapng")
