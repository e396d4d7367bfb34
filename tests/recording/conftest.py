"""Where a test's capture is; and a recorder on a virtual unit's line."""

from __future__ import annotations

import pytest

from mikas.recording.recorder import Recorder


@pytest.fixture
def path(tmp_path):
    return tmp_path / "line.pcapng"


@pytest.fixture
def recorder():
    return Recorder()
