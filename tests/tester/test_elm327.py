"""An ELM327 is no adapter for this, and a Mikas is not taken for one."""

from __future__ import annotations

import pytest
from tester_rig import ScriptedLink, Watched, make

from mikas.errors import NotAKLineAdapter
from mikas.tester import Echo


@pytest.mark.parametrize("elm_echo", [True, False])
@pytest.mark.parametrize("mode", list(Echo))
@pytest.mark.parametrize("reply", [b"?\r\r>", b"\r?\r\r>", b"?\r\n\r\n>", b"STOPPED\r\r>", b"?\r"])
@pytest.mark.parametrize("lumps", [True, False])
def test_an_elm327_is_no_adapter_for_this(elm_echo, mode, reply, lumps):
    pieces = [reply] if lumps else [bytes([b]) for b in reply]
    link = ScriptedLink(
        lambda sent: [(0.02 + 0.001 * i, piece) for i, piece in enumerate(pieces)], echo=elm_echo
    )
    with pytest.raises(NotAKLineAdapter) as caught:
        make(link, echo=mode).connect()
    assert "ELM327" in str(caught.value)
    assert caught.value.received.endswith(reply)


@pytest.mark.parametrize("elm_echo", [True, False])
@pytest.mark.parametrize("retries", [0, 2])
def test_an_elm327_that_answers_late_is_no_adapter_either(elm_echo, retries):
    link = ScriptedLink(lambda sent: [(0.55, b"?\r\r>")], echo=elm_echo)
    with pytest.raises(NotAKLineAdapter):
        make(link, retries=retries).connect()


def test_a_mikas_is_not_taken_for_an_elm327():
    """Its version code may be any character, and the line may be noisy."""
    for version in b"?>A\r":
        assert Watched(version=version).connected().version_code == version
