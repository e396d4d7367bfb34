"""mikas: diagnostics for the Mikas 5.4 and 7.1 engine control units over K-Line.

    import mikas
    with mikas.connect("/dev/ttyUSB0") as ecu:
        print(ecu.read("TWAT", "FREQ"))
    frame = mikas.open("drive.pcapng").to_pandas()

The names in `__all__`, and `mikas.open` (as `gzip.open`), are the public interface. Each is
imported when it is first used, so that a program that only prints its help does not load all of it.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mikas import errors
    from mikas.catalog import Fault, Parameter
    from mikas.client import (
        AsyncEcu,
        Change,
        DerivedValue,
        Ecu,
        Info,
        Passport,
        Reading,
        Sample,
        connect,
    )
    from mikas.errors import MikasError
    from mikas.foreign_logs.opening import open_log
    from mikas.foreign_logs.table import ForeignLog
    from mikas.live.asynchronous import AsyncSession, async_session
    from mikas.live.session import Session
    from mikas.live.starting import session
    from mikas.notebook.recording import Recording
    from mikas.notebook.recording import open as open  # noqa: A004  (read as `mikas.open`)

    __version__: str

__all__ = [
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

_MODULES = dict.fromkeys(__all__, "mikas.client") | {
    "Fault": "mikas.catalog",
    "ForeignLog": "mikas.foreign_logs.table",
    "MikasError": "mikas.errors",
    "Session": "mikas.live.session",
    "AsyncSession": "mikas.live.asynchronous",
    "async_session": "mikas.live.asynchronous",
    "session": "mikas.live.starting",
    "Parameter": "mikas.catalog",
    "open_log": "mikas.foreign_logs.opening",
    "Recording": "mikas.notebook.recording",
    "open": "mikas.notebook.recording",  # not in `__all__`: `import *` would hide the built-in one
}


if not TYPE_CHECKING:  # for a type checker, what is not above does not exist

    def __getattr__(name: str) -> object:
        if name == "__version__":
            from importlib.metadata import version

            return version("mikas")
        if name == "errors":
            return import_module("mikas.errors")
        if name in _MODULES:
            return getattr(import_module(_MODULES[name]), name)
        raise AttributeError(_absent(name))


def _absent(name: str) -> str:
    from mikas.options import nearest

    near = () if name.startswith("_") else nearest(name, __dir__())
    meant = "".join(f". Did you mean {each}?" for each in near)
    return f"module 'mikas' has no attribute {name!r}{meant}"


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__", "open"])
