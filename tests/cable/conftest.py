"""A box for all tests of a worker. Skipped as a whole where there is no QEMU or kernel, unless
`MIKAS_REQUIRE_CABLE` is set, as `make cable` does: then that is a failure.
"""

from __future__ import annotations

import compileall
import os
import sys

import pytest

from cable.box_rig import Box
from cable.image_rig import REPOSITORY, missing

collect_ignore_glob = [] if sys.platform == "linux" else ["*"]


@pytest.fixture(scope="session")
def running_box(tmp_path_factory):
    if reason := missing():
        if os.environ.get("MIKAS_REQUIRE_CABLE"):
            pytest.fail(reason)
        pytest.skip(reason)  # `make cable` and .ci/run require it
    compileall.compile_dir(REPOSITORY / "src", quiet=1)  # the guest can't write there
    box = Box(tmp_path_factory.mktemp("box"), pauses=30.0)  # a busy computer runs it in jerks
    yield box
    box.close()


@pytest.fixture
def box(running_box, request):
    """The guest, with all cables out and an empty home."""
    running_box.home = running_box.folder / request.node.name
    running_box.home.mkdir()
    yield running_box
    running_box.restore()


@pytest.fixture
def cable(box, request):
    """A plugged cable with a warm car behind it, as `/dev/ttyUSB0`.

    With an FT232R, or the chips that a test is parametrized with (`indirect`).
    """
    cable = box.cable(chip=getattr(request, "param", "FT232R"))
    cable.plug()
    return cable
