"""The page's drivers in Node, for all tests of a worker."""

from __future__ import annotations

import os

import pytest

from usb.page import node_rig


@pytest.fixture(scope="package")
def drivers(tmp_path_factory):
    if reason := node_rig.missing():
        if os.environ.get("MIKAS_REQUIRE_NODE"):
            pytest.fail(reason)
        pytest.skip(reason)
    with node_rig.started("drivers_in_node.js", tmp_path_factory.mktemp("drivers")) as process:
        yield node_rig.Drivers(process)
