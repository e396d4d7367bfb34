"""The tables of `tests/actions`, on the page without installation: one page for all rows."""

from __future__ import annotations

import pytest

from actions.driving import drive
from actions.page import BY_MESSAGES, KEEP_WORKERS, asking
from actions.routes import ROUTES
from actions.screens import BEFORE, READY, ROWS
from actions.steps import do

from .site_rig import site_tab

pytestmark = pytest.mark.realtime


@pytest.fixture
def virtual(chromium, site):
    """A tab on the virtual car, with a recording of it: each test's own, as they change it."""
    with chromium.new_context(locale="en-GB") as context:
        context.add_init_script(KEEP_WORKERS)
        with site_tab(context, site.url) as tab:
            ask = asking(tab.open("live").page, BY_MESSAGES)
            assert do(tab, BEFORE, "site") == []
            assert drive(ask, READY, "site") == []
            tab.is_line("sampling")
            yield tab


def test_everything_that_the_screens_offer_is_done(virtual):
    assert do(virtual, ROWS, "site") == []


def test_every_route_answers(virtual):
    virtual.show("connection")
    assert drive(asking(virtual.page, BY_MESSAGES), ROUTES, "site") == []
