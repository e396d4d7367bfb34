"""The page's drivers in Node, for all tests of a worker."""

from __future__ import annotations

import pytest

from usb.page import node_rig


@pytest.fixture(scope="package")
def drivers(tmp_path_factory):
    node_rig.require()
    with node_rig.started("drivers_in_node.js", tmp_path_factory.mktemp("drivers")) as process:
        yield node_rig.Drivers(process)
