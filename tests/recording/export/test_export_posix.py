"""A disk that takes no more, with every format: the limit on a file's size stands in for it."""

from __future__ import annotations

import resource
from contextlib import contextmanager

import numpy as np
import pytest
from export_tables import CHANNELS

from mikas.errors import ExportError
from mikas.recording.export import SUFFIXES, export
from mikas.recording.table.channels import Rows


@contextmanager
def disk_of(size):
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_full_disk_is_an_error_and_leaves_no_file(tmp_path, suffix):
    out = tmp_path / f"log{suffix}"
    chance = np.random.default_rng(7)
    pieces = (
        Rows(np.arange(1000.0) + at, {c.name: chance.random(1000) for c in CHANNELS})
        for at in range(0, 50_000, 1000)
    )
    export(tmp_path / f"first{suffix}", CHANNELS, [])  # imports may write their caches
    (tmp_path / f"first{suffix}").unlink()
    with disk_of(100_000), pytest.raises(ExportError, match="can't be written") as caught:
        export(out, CHANNELS, pieces)
    assert str(out) in str(caught.value)
    assert list(tmp_path.iterdir()) == []
