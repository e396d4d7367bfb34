"""mikas: diagnostics for the Mikas 5.4 and 7.1 engine control units over K-Line.

    import mikas
    with mikas.connect("/dev/ttyUSB0") as ecu:
        print(ecu.read("TWAT", "FREQ"))
    frame = mikas.open("drive.pcapng").to_pandas()

What is named here is the public interface; it is imported when it is first used, so that a program
that only wants to print its help does not wait for all of it.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mikas import errors
    from mikas.client import AsyncEcu, Change, Ecu, Reading, Sample, connect
    from mikas.errors import MikasError
    from mikas.recording.opening import open  # noqa: A004  (read as `mikas.open`)

__all__ = [
    "AsyncEcu",
    "Change",
    "Ecu",
    "MikasError",
    "Reading",
    "Sample",
    "connect",
    "errors",
    "open",
]

_HOMES = dict.fromkeys(__all__, "mikas.client") | {
    "MikasError": "mikas.errors",
    "open": "mikas.recording.opening",
}


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import version

        return version("mikas")
    if name == "errors":
        return import_module("mikas.errors")
    if name in _HOMES:
        return getattr(import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'mikas' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
