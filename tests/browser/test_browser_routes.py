"""Every route of the API, asked by a page of the desktop: tests/actions/routes.py."""

from __future__ import annotations

import pytest

from actions.driving import drive
from actions.page import WITH_FETCH, asking
from actions.routes import ROUTES

pytestmark = pytest.mark.realtime


def test_every_route_answers(own, visitor):
    tab = visitor(own.url).show("connection")
    tab.refused = True  # some rows are refused, and the console says so
    assert drive(asking(tab.page, WITH_FETCH), ROUTES, "desktop") == []
