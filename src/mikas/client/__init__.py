"""The public object `Ecu` and its types; `AsyncEcu` and asyncio are imported at first use."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mikas.client.connecting import ConnectionOptions, connect
from mikas.client.ecu import Ecu
from mikas.client.erasing import Erased
from mikas.client.gate import Change, Confirm
from mikas.client.identity import Info, Passport
from mikas.client.limits import Limits
from mikas.client.memory.spaces import Memory, MemorySpace, Run, Written
from mikas.client.parameters.derived import DerivedValue
from mikas.client.parameters.parameters import WrittenParameter
from mikas.client.parameters.polling import METHODS, Method
from mikas.client.parameters.readings import Reading, Sample
from mikas.client.recorded import EcuRecording
from mikas.client.scanning import Answer, ScannedCode
from mikas.client.support import Support

if TYPE_CHECKING:
    from mikas.client.asynchronous import AsyncEcu, AsyncItems, AsyncMemory, AsyncMemorySpace

__all__ = [
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

_ASYNCHRONOUS = ("AsyncEcu", "AsyncItems", "AsyncMemory", "AsyncMemorySpace")


def __getattr__(name: str) -> object:
    if name in _ASYNCHRONOUS:
        from mikas.client import asynchronous

        return getattr(asynchronous, name)
    raise AttributeError(f"module 'mikas.client' has no attribute {name!r}")
