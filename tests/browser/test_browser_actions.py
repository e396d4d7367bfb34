"""The tables of `tests/actions` on the desktop: all that a person does, and every route.

What opens on the way is photographed by day and by night, and axe has nothing against it.
"""

from __future__ import annotations

import pytest

from actions.driving import drive
from actions.page import WITH_FETCH, asking
from actions.routes import ROUTES
from actions.screens import BEFORE, READY, ROWS
from actions.steps import do
from browser.rig import dashboard
from browser.test_browser_screens import in_each_theme

pytestmark = pytest.mark.realtime


@pytest.fixture(scope="module")
def driven(chromium, tmp_path_factory):
    """A program without an adapter: the tables start their virtual car."""
    with dashboard(tmp_path_factory.mktemp("driven"), begin=False) as dash:
        yield dash


@pytest.fixture
def tab(driven, visitor):
    tab = visitor(driven.url).show("connection")
    tab.refused = True  # some routes are refused, and the console says so
    return tab


def test_everything_that_the_screens_offer_is_done(tab):
    assert do(tab, BEFORE, "desktop") == []
    assert drive(asking(tab.page, WITH_FETCH), READY, "desktop") == []
    tab.is_line("sampling")
    findings = {}

    def look(row, shot):
        findings.update(in_each_theme(tab, f"{row.screen}-{shot.name}-en"))

    assert do(tab, ROWS, "desktop", look) == []
    assert findings == {}


def test_every_route_answers(tab):
    assert drive(asking(tab.page, WITH_FETCH), ROUTES, "desktop") == []
