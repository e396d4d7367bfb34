"""Skipped as a whole where there is no Chromium, or where the page was not built, unless
`MIKAS_REQUIRE_CHROMIUM` is set: then that is a failure.
"""

from __future__ import annotations

import pytest

from browser.chromium_rig import installed, must_not_miss, started, visits
from browser.rig import dashboard
from mikas.dashboard.page import FOLDER


@pytest.fixture(scope="package")
def chromium():
    program = installed()
    built = (FOLDER / "index.html").is_file()
    must_not_miss("" if built else "the page was not built: pip install .")
    must_not_miss("" if program else "Chromium is not installed")
    with started(program) as browser:
        yield browser


@pytest.fixture
def visitor(chromium):
    """Opens tabs: `visitor(url, locale="ru-RU", …)`, each in a browser profile of its own."""
    with visits(chromium) as visit:
        yield visit


@pytest.fixture(scope="module")
def served(chromium, tmp_path_factory):
    """The program, connected to a car; shared by a module's tests."""
    with dashboard(tmp_path_factory.mktemp("served")) as dash:
        yield dash.samples()


@pytest.fixture
def dash(served):
    """That program, with no client in control."""
    served.nobody_controls()
    return served


@pytest.fixture
def own(chromium, tmp_path):
    """A program with a car of the test's own, to be changed."""
    with dashboard(tmp_path) as dash:
        yield dash.samples()
