"""`idle`: the application with a warm car at idle; `off`: with nothing connected. `shared_…`: one
for all tests of a module that leave no trace.
"""

from __future__ import annotations

import pytest

from dashboard.rig import rig


@pytest.fixture
def idle(tmp_path):
    with rig(tmp_path, "sim:?scenario=warm-idle") as it:
        it.sampling()
        yield it


@pytest.fixture
def off(tmp_path):
    with rig(tmp_path, None) as it:
        yield it


@pytest.fixture(scope="module")
def shared_idle(tmp_path_factory):
    with rig(tmp_path_factory.mktemp("idle"), "sim:?scenario=warm-idle") as it:
        it.sampling()
        it.post("/unlock", {"minutes": 30})
        yield it


@pytest.fixture(scope="module")
def shared_off(tmp_path_factory):
    with rig(tmp_path_factory.mktemp("off"), None) as it:
        yield it
