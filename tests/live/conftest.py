"""A virtual unit, and sessions on it."""

from __future__ import annotations

import pytest

import mikas
from mikas.testing.units import VirtualUnit

SIM = "sim:?clock=simulated"


@pytest.fixture
def unit():
    with VirtualUnit() as made:
        yield made


@pytest.fixture
def on_unit(unit):
    """A session on that unit; its port can be opened again."""
    made = []

    def make(*args, **options):
        made.append(mikas.session(SIM, *args, open_port=lambda _: unit.link(), **options))
        return made[-1]

    yield make
    for each in made:
        each.close()
