"""Ctrl-C closes the link of `mikas dash` while its sampling thread uses it: that is `LinkLost`."""

from __future__ import annotations

from itertools import product

import pytest

from .closing import close_at_each_line
from .rigs import asked_rig, rfc2217_rig, tcp_rig

pytestmark = pytest.mark.realtime

RIGS = [asked_rig, tcp_rig, rfc2217_rig]
USES = {
    "write": lambda link: link.write(b"\x01\xff\r"),
    "read": lambda link: link.read(link.now()),
    "break": lambda link: link.send_break(0),
}


@pytest.mark.parametrize(("rig", "use"), [*product(RIGS, USES)])
def test_closing_by_another_thread_at_any_moment_ends_the_call(rig, use):
    assert close_at_each_line(rig, USES[use]) > 1
