"""The meaning of each field that an error has in `fields`, for the reference of the library."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

MEANINGS: Mapping[str, str] = MappingProxyType(
    {
        "address": "the first address",
        "allowed": "the values that do fit, in words",
        "asked": "the address that was requested",
        "baud": "bits a second of the line",
        "change": "the change in words, a `Text`",
        "chip": "the adapter's chip",
        "command": "the command's name and code, a `Text`",
        "count": "the number of bytes",
        "damage": "the fault of the bytes, a `Text`",
        "example": "what a port may look like on this system",
        "expected": "the lengths that fit, in words",
        "extra": "the extra to install, as in `mikas[parquet]`",
        "feature": "what needs the library",
        "file": "the file's path",
        "found": "the ports that there are, in words",
        "got": "what came instead",
        "holder": "the program that has it, a `Text`",
        "how": "why it was not confirmed, a `Text`",
        "last": "the highest address",
        "length": "the bytes of the response's body",
        "limit": "the time-out in force, in seconds",
        "most": "the most bytes a second that the line carries",
        "name": "the name as it was given",
        "nearest": "the nearest names, as a sentence",
        "place": "the file with its line, or the address of a dataset without its password",
        "problem": "the problem, a `Text` or a string",
        "rate": "bytes a second that come",
        "said": "the first words of that service",
        "seconds": "how long it took, in seconds",
        "service": "the service that answers there",
        "space": "the memory space",
        "total": "the channel that adds up",
        "url": "the address of the port or the broker, without its password",
        "value": "the value that was given",
        "wanted": "the value that should be there; of a time-out, in seconds",
        "where": "the line or the byte in the file, a `Text`; empty: unknown",
    }
)
