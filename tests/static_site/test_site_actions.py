"""The tables of `tests/actions`, on the page without installation: one page for all rows."""

from __future__ import annotations

import pytest

from actions.driving import drive
from actions.page import BY_MESSAGES, KEEP_WORKERS, asking
from actions.routes import CAR, ROUTES, post
from actions.screens import ACTIONS, each_opened

from .site_rig import site_tab

pytestmark = pytest.mark.realtime

STARTED = (
    post("/control/take", {"force": True}),
    post("/connect", {"port": f"{CAR}&faults=17,41"}),
    post("/control/release"),
)


@pytest.fixture(scope="module")
def virtual(chromium, site):
    """A tab on the virtual car, with a recording of it."""
    with chromium.new_context(locale="en-GB") as context:
        context.add_init_script(KEEP_WORKERS)
        with site_tab(context, site.url) as tab:
            ask = asking(tab.open("live").page, BY_MESSAGES)
            assert drive(ask, STARTED, "site") == []
            tab.is_line("sampling")
            tab.record()
            tab.recorded(1)
            tab.stop_recording()
            yield tab


def test_every_screen_opens_what_it_offers(virtual):
    assert len(list(each_opened(virtual))) == len(ACTIONS)


def test_every_route_answers(virtual):
    virtual.show("connection")
    assert drive(asking(virtual.page, BY_MESSAGES), ROUTES, "site") == []
