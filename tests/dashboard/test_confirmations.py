"""The approval of changes: the sampler's own, and exactly the confirmed one."""

from __future__ import annotations

from dataclasses import replace

import pytest

from mikas.client import Change
from mikas.commands import Safety
from mikas.dashboard.errors import ConfirmationOutdated
from mikas.dashboard.security.control import WriteApproval
from mikas.errors import NotConfirmed
from mikas.i18n import Text

WRITE = Change(Text("a write", "запись"), Safety.DANGEROUS, "31", before="0A", after="0B")


@pytest.mark.parametrize("safety", Safety)
def test_unasked_passes_only_what_the_ignition_undoes(safety):
    assert WriteApproval().confirm(replace(WRITE, safety=safety)) is (safety <= Safety.REVERSIBLE)


def test_what_was_confirmed_passes_and_nothing_after_it():
    it = WriteApproval()
    with it.given("0A"):
        assert it.confirm(WRITE)
    assert not it.confirm(WRITE)
    with pytest.raises(ZeroDivisionError), it.given("0A"):
        raise ZeroDivisionError
    assert not it.confirm(WRITE)


def test_what_is_no_longer_as_it_was_shown_does_not_pass():
    it = WriteApproval()
    for shown in ("0B", None):
        with it.given(shown), pytest.raises(ConfirmationOutdated):
            it.confirm(WRITE)


def test_a_parameter_may_have_moved_since_but_only_the_shown_bytes_are_written():
    it, write = WriteApproval(), replace(WRITE, name="UOZ", safety=Safety.LASTING)
    with it.given_to("UOZ", "0B"):
        assert it.confirm(replace(write, before="77"))
        for other in (replace(write, after="0C"), replace(write, name="SSM"), WRITE):
            with pytest.raises(ConfirmationOutdated):
                it.confirm(other)
    assert not it.confirm(write)


def test_a_dangerous_change_without_confirmation_does_not_reach_the_unit(idle):
    """Whoever asks for it inside the program; changes are locked, and no client has confirmed."""

    def ask(job):
        return idle.dashboard.connection.thread.acquisition.call(job).result(60)

    before = ask(lambda ecu: ecu.memory.code.read(0x9000))
    with pytest.raises(NotConfirmed):
        ask(lambda ecu: ecu.memory.code.write(0x9000, before ^ 0xFF))
    assert ask(lambda ecu: ecu.memory.code.read(0x9000)) == before
    assert idle.get("/journal") == {"entries": []}
