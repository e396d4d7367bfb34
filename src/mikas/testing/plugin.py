"""The pytest plugin: fixtures `car` and `virtual_ecu`, and the mark `mikas_car`.

    @pytest.mark.mikas_car(scenario="city", faults="17,81")
    def test_reads_faults(car, virtual_ecu):
        ...

pytest finds it where mikas is installed. Nothing of mikas is imported before a test wants it.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from mikas.client import Ecu
    from mikas.testing.units import VirtualUnit


def pytest_configure(config: pytest.Config) -> None:
    """Register the mark."""
    config.addinivalue_line(
        "markers", "mikas_car(**options): options of `sim:` for the fixtures car and virtual_ecu"
    )


@pytest.fixture
def car(request: pytest.FixtureRequest) -> Iterator[VirtualUnit]:
    """A virtual unit of this test's own, by the options of the marks `mikas_car`."""
    from mikas.testing.units import VirtualUnit

    with VirtualUnit(**_options(request.node)) as unit:
        yield unit


def _options(test: pytest.Item) -> dict[str, str | float]:
    """Return the options of the marks: those of the test come before those of its class."""
    options: dict[str, str | float] = {}
    for mark in test.iter_markers("mikas_car"):  # the closest one comes first
        if mark.args:
            raise pytest.UsageError(
                f"mikas_car takes options by name, as in mikas_car(scenario={mark.args[0]!r})"
            )
        options = {**mark.kwargs, **options}
    return options


@pytest.fixture
def virtual_ecu(car: VirtualUnit) -> Iterator[Ecu]:
    """An `Ecu` connected to `car`."""
    with car.connect() as ecu:
        yield ecu
