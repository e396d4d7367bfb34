"""The locks of the other systems: macOS' on whole files, Windows' by its C library, a browser's
none. Windows' is a fake here that locks as it does.
"""

from __future__ import annotations

import errno
import fcntl
import os
import runpy
import sys
import types

import pytest

from mikas.errors import UnfitFile
from mikas.files import locks as file_locks


class Msvcrt(types.ModuleType):
    LK_NBLCK, LK_UNLCK = 2, 0

    def __init__(self):
        super().__init__("msvcrt")
        self.places = set()

    def locking(self, descriptor, mode, count):
        self.places.add(os.lseek(descriptor, 0, os.SEEK_CUR))
        assert count == 1
        if mode == self.LK_UNLCK:
            fcntl.flock(descriptor, fcntl.LOCK_UN)
            return
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise PermissionError(errno.EACCES, "Permission denied") from None


@pytest.fixture(params=["linux", "darwin", "win32"])
def locks(request, monkeypatch):
    if request.param == sys.platform:
        return vars(file_locks)
    msvcrt = Msvcrt()
    monkeypatch.setitem(sys.modules, "msvcrt", msvcrt)
    monkeypatch.setattr(sys, "platform", request.param)
    return runpy.run_path(file_locks.__file__) | {"fake": msvcrt}


def test_a_file_is_held_until_it_is_closed(locks, tmp_path):
    path = tmp_path / "a"
    path.write_bytes(b"12345678")
    with path.open("r+b", buffering=0) as file:
        file.seek(3)
        locks["hold"](file)
        assert file.tell() == 3
        for _ in range(2):
            with pytest.raises(UnfitFile, match="another program"):
                locks["check_free"](path)
            with path.open("r+b", buffering=0) as other, pytest.raises(UnfitFile):
                locks["hold"](other)
        with path.open("rb") as reader:
            assert reader.read() == b"12345678"
    for _ in range(2):
        locks["check_free"](path)
    if (fake := locks.get("fake")) and fake.places:
        assert fake.places == {1 << 40}


def test_where_there_are_no_locks_no_file_is_held(monkeypatch, tmp_path):
    monkeypatch.setattr(sys, "platform", "emscripten")
    monkeypatch.setitem(sys.modules, "fcntl", None)
    locks = runpy.run_path(file_locks.__file__)
    path = tmp_path / "a"
    with path.open("xb") as file:
        locks["hold"](file)
        locks["check_free"](path)
    locks["check_free"](tmp_path / "missing")


def test_a_file_system_without_locks_is_no_reason_to_refuse(monkeypatch, tmp_path):
    def unsupported(*_):
        raise OSError(errno.EOPNOTSUPP, "Operation not supported")

    monkeypatch.setattr(fcntl, "fcntl", unsupported)
    monkeypatch.setattr(fcntl, "flock", unsupported)
    path = tmp_path / "a"
    with path.open("xb") as file:
        file_locks.hold(file)
        file_locks.check_free(path)


@pytest.mark.parametrize(
    "words",
    [
        ["--port=rfc2217://me:zq0000001%2B@car"],
        ["--port", "rfc2217://me:zq0000001%2B@car"],
        ["s3://bucket/a?sig=zq0000001"],
    ],
)
def test_the_command_of_another_program_is_shown_without_its_secrets(tmp_path, words):
    command = ["/usr/bin/python3", "/usr/bin/mikas", "log", *words]
    (tmp_path / "cmdline").write_bytes("\0".join([*command, ""]).encode())
    shown = vars(file_locks)["_command"](tmp_path)
    assert shown.startswith("mikas log ")
    assert "://" in shown
    assert "zq" not in shown
