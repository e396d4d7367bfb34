"""Classes of errors that are also the system's: a `CaptureError` that is a `FileNotFoundError`.

As `OSError(errno.ENOENT, …)` is a `FileNotFoundError`, the builtin class follows from the number.
"""

from __future__ import annotations

import builtins
import errno
import os
from typing import Final, TypeVar, cast

X = TypeVar("X", bound=Exception)

_NUMBERS: Final = {
    FileNotFoundError: errno.ENOENT,
    PermissionError: errno.EACCES,
    FileExistsError: errno.EEXIST,
    IsADirectoryError: errno.EISDIR,
    NotADirectoryError: errno.ENOTDIR,
    TimeoutError: errno.ETIMEDOUT,
    ConnectionRefusedError: errno.ECONNREFUSED,
    ConnectionResetError: errno.ECONNRESET,
    BrokenPipeError: errno.EPIPE,
}
"""Of errors that a library raises without a number."""

_OWN_NUMBERS: Final = frozenset({"ssl", "socket"})
"""Modules whose errors are `OSError` with numbers of another list."""


_MADE: Final[dict[tuple[type[Exception], type[OSError]], type[Exception]]] = {}


def also(kind: type[X], builtin: type[OSError]) -> type[X]:
    """Return the class of errors that are both, with the name of `kind`: always the same one.

    An `ImportError` can't be both.
    """
    if issubclass(kind, builtin) or issubclass(kind, ImportError):
        return kind
    if known := _MADE.get((kind, builtin)):
        return cast("type[X]", known)
    names = {
        "__module__": kind.__module__,
        "__qualname__": kind.__qualname__,
        "__doc__": kind.__doc__,
        "made": True,
    }
    base = kind.__bases__[0] if kind.__dict__.get("made") else kind
    made = _MADE[kind, builtin] = type(kind.__name__, (base, builtin), names)
    return cast("type[X]", made)


def system_error(number: int) -> OSError:
    """Return the system's error of this number, in the class that Python has for it."""
    return OSError(number, os.strerror(number))


def builtin_of(error: OSError) -> type[OSError]:
    """Return the builtin class of a system's error, whatever its own class is."""
    number = number_of(error)
    if number is not None:
        return type(OSError(number, ""))
    kinds = (builtin_named(kind.__name__) for kind in type(error).__mro__)
    return next(kind for kind in kinds if kind is not None)


def builtin_named(name: str) -> type[OSError] | None:
    """Return the builtin class of this name; None: there is none, or it is no `OSError`."""
    kind = vars(builtins).get(name)
    return kind if isinstance(kind, type) and issubclass(kind, OSError) else None


def number_of(error: OSError) -> int | None:
    """Return the number of a system's error, if need be that of its class."""
    if error.errno is not None and type(error).__module__ not in _OWN_NUMBERS:
        return error.errno
    return next((number for kind, number in _NUMBERS.items() if isinstance(error, kind)), None)


def describe(
    error: OSError, number: int | None, words: str | None = None, file: object = None
) -> None:
    """Fill the fields that each error of the system has."""
    error.errno = number
    error.strerror = words or (None if number is None else os.strerror(number))
    error.filename = file
