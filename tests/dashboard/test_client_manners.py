"""Clients of every manner end nothing but their own connection: sampling, the recording and the
owner's page go on, nothing is reported, and each place is given back. More of them, drawn from a
seed: `python -m fuzz clients`.
"""

from __future__ import annotations

import sys
from contextlib import ExitStack
from random import Random

import pytest
from fuzz.clients.manners import MANNERS, STAGES, Crowd, network_of, run
from fuzz.clients.world import clients_context, world

pytestmark = pytest.mark.skipif(
    sys.platform != "linux", reason="each address of 127.0.0.0/8 is a client in the network"
)
ONE_SETTING = {
    "closes_at_each_byte": [(True, False), (False, True)],
    "closes_often_in_a_row": [(True, True)],
    "floods_with_connections": [(True, False)],
    "says_goodbye_late": [(True, False), (True, True)],
}
"""Of manners that take long: with TLS, with the token."""
ALL = [(tls, token) for tls in (True, False) for token in (True, False)]
CASES = [(name, *setting) for name in MANNERS for setting in ONE_SETTING.get(name, ALL)]


@pytest.fixture(scope="module")
def worlds(tmp_path_factory):
    """The dashboards that were asked for so far, with TLS and without."""
    with ExitStack() as opened:
        found = {}

        def of(tls):
            if tls not in found:
                found[tls] = opened.enter_context(world(tmp_path_factory.mktemp("world"), tls=tls))
            return found[tls]

        yield of


@pytest.mark.parametrize(("manner", "tls", "token"), CASES)
def test_a_client_of_this_manner_ends_nothing_but_itself(worlds, manner, tls, token):
    run(network_of(worlds(tls), clients_context(), Random(1), token=token), MANNERS[manner])


@pytest.mark.parametrize(("tls", "token"), ALL)
def test_a_crowd_of_clients_ends_nothing_but_itself(worlds, tls, token):
    run(
        network_of(worlds(tls), clients_context(), Random(7), token=token),
        lambda it: Crowd(it).visit(60),
    )


@pytest.mark.parametrize("tls", [True, False])
def test_the_program_ends_in_good_order_whatever_clients_are_there(tmp_path, tls):
    with world(tmp_path, tls=tls) as it:
        it.record()
        network = network_of(it, clients_context(), Random(1), token=True)
        callers = [stage(network) for stage in STAGES.values()]
        callers += [STAGES[name](network) for name in ("violation", "websocket", "closed")]
    network.close()  # by now the program has ended, and reported nothing
    assert it.dashboard.recorder.last.failure is None
    assert len(callers) == len(STAGES) + 3
