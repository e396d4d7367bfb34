"""The public object and what its methods give."""

from mikas.client.asynchronous import AsyncEcu
from mikas.client.connecting import connect
from mikas.client.ecu import Ecu, Erased
from mikas.client.gate import Change, Confirm
from mikas.client.identity import Info, Passport, Support
from mikas.client.limits import Limits
from mikas.client.memory import Memory, MemorySpace, Written
from mikas.client.parameters import WrittenParameter
from mikas.client.reading import Reading, Sample
from mikas.client.watching import METHODS, Method

__all__ = [
    "METHODS",
    "AsyncEcu",
    "Change",
    "Confirm",
    "Ecu",
    "Erased",
    "Info",
    "Limits",
    "Memory",
    "MemorySpace",
    "Method",
    "Passport",
    "Reading",
    "Sample",
    "Support",
    "Written",
    "WrittenParameter",
    "connect",
]
