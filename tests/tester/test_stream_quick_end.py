"""A stream that keeps the wire full is ended without a pause, wherever the first `01` falls (D12):
a busy computer sends it late, into the middle of a response.
"""

from __future__ import annotations

import pytest
from stream_cases import SEVERAL
from tester_rig import ECHOING, SLOW, Watched, adapter_name

from mikas import commands as c

_LATE = 1.0  # s that it would take to be sure of a line without an answer


@pytest.mark.parametrize("adapter", [ECHOING, SLOW], ids=adapter_name)
@pytest.mark.parametrize("phase", range(16))
def test_the_first_interruption_may_collide(phase, adapter, monkeypatch):
    unit = Watched(adapter=adapter)
    tester = unit.connected()
    with tester.stream(c.StreamCyclic(SEVERAL)) as stream:
        for _ in range(3):
            next(stream)
        sync, in_a_gap = tester.sync, tester.sync._wait_for_gap  # noqa: SLF001

        def late():
            unit.link.read(unit.link.now() + phase * unit.link.byte_time / 2)
            monkeypatch.setattr(sync, "_wait_for_gap", in_a_gap)

        monkeypatch.setattr(sync, "_wait_for_gap", late)
        began = unit.link.now()
    assert unit.link.now() - began < _LATE
    assert unit.count_of("stream") == unit.count_of("stream-end") == 1
