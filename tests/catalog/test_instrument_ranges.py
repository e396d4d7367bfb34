"""The range of an instrument's channel: a value outside of it is damage."""

from __future__ import annotations

import pytest

from mikas.catalog.instrument_channels import InstrumentChannel
from mikas.i18n import Text


@pytest.mark.parametrize(
    ("given", "value", "taken"),
    [
        (None, -1e9, True),
        ((0.5, 1.5), 0.5, True),
        ((0.5, 1.5), 1.5, True),
        ((0.5, 1.5), 0.49, False),
        ((0.5, 1.5), 1.51, False),
    ],
)
def test_a_channel_takes_what_lies_in_its_range(given, value, taken) -> None:
    channel = InstrumentChannel("LAMBDA", Text("Mixture", "Смесь"), range=given)
    assert channel.takes(value) is taken
