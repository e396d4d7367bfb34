"""The streams that the tests begin (D12, D15), and what each of them gives."""

from __future__ import annotations

import pytest
from tester_rig import DATA, ECHOING, SILENT_ADAPTER, SLOW, adapter_name

from mikas import commands as c
from mikas.virtual.quirks import StreamEnd

ONE = (c.Datum(16, 1),)  # 0A, the very version code
SEVERAL = (c.Datum(22, 1), c.Datum(67, 2), c.Datum(20, 1))
CYCLIC = [c.StreamCyclic(ONE), c.StreamCyclic(SEVERAL)]
BY_STROKES = [*(c.StreamAtStroke(SEVERAL, stroke) for stroke in range(5)), c.StreamAtStroke(ONE, 0)]
STREAMS = CYCLIC + BY_STROKES
each_end = pytest.mark.parametrize("end", list(StreamEnd))
each_stream = pytest.mark.parametrize("command", STREAMS, ids=lambda s: s.body().hex())
each_adapter = pytest.mark.parametrize("adapter", [ECHOING, SLOW, SILENT_ADAPTER], ids=adapter_name)


def expected(command):
    return tuple(DATA[p.code] for p in command.parameters)
