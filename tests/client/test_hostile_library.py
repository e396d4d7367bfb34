"""The library's main calls against every manner of a hostile unit, on simulated time."""

from __future__ import annotations

from contextlib import closing
from itertools import islice

import pytest

import mikas
from hostile_rig import CONNECTED, MANNERS, URL, hostile
from mikas.errors import MikasError, UsageError
from tester.tester_rig import case


def some(samples):
    with closing(samples):
        return list(islice(samples, 5))


CALLS = {
    "read": lambda ecu: ecu.read("FREQ", "TWAT"),
    "watch": lambda ecu: some(ecu.watch("FREQ")),
    "stream": lambda ecu: some(ecu.watch("FREQ", "TWAT", method="stream")),
    "faults": lambda ecu: ecu.faults(),
    "passport": lambda ecu: ecu.passport(),
    "info": lambda ecu: ecu.info,
    "supported": lambda ecu: list(ecu.supported()),
    "read_list": lambda ecu: ecu.read_list("FREQ", "TWAT"),
    "memory": lambda ecu: ecu.memory.ram.read_block(0, 64),
    "write": lambda ecu: ecu.write_parameter("UOZ", 1),
    "erase": lambda ecu: ecu.erase_faults(),
    "raw": lambda ecu: ecu.raw(b"\x02"),
}


@pytest.mark.parametrize("name", CALLS)
def test_the_call_returns_or_raises_an_error_of_mikas(name, tmp_path):
    for manner in MANNERS:
        with case(manner.__name__), hostile(manner, since=CONNECTED) as world:
            with mikas.connect(URL, journal=tmp_path / "journal", state=tmp_path) as ecu:
                try:
                    CALLS[name](ecu)
                except MikasError as error:
                    assert not isinstance(error, UsageError)
                    assert error.text.ru
            assert world.brought <= world.most_bytes


def test_a_connection_is_made_or_refused(tmp_path):
    for manner in MANNERS:
        with case(manner.__name__), hostile(manner, since=0.0) as world:
            try:
                mikas.connect(URL, state=tmp_path).close()
            except MikasError as error:
                assert error.text.ru
            assert world.time <= 60
