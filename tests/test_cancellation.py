"""Work that ends when it is asked to: the flag, and every reader of a recording."""

from __future__ import annotations

import pytest

import mikas
from dashboard.recordings_rig import record
from mikas.cancellation import Cancellation, Cancelled, check_cancelled
from mikas.catalog import shipped
from mikas.recording.export import export
from mikas.recording.recording import Recording
from mikas.recording.summary import summarise
from mikas.report.from_recording import find_in_recording


class AfterChecks(Cancellation):
    """Requested at the check of that number."""

    __slots__ = ("left",)

    def __init__(self, checks):
        self.left = checks
        super().__init__()

    @property
    def requested(self):
        self.left -= 1
        return self.left < 0

    @requested.setter
    def requested(self, _):
        pass


def test_work_ends_at_the_check_after_the_request():
    cancellation, done = Cancellation(), []

    def work():
        for step in range(5):
            done.append(step)
            if step == 2:
                cancellation.request()
            check_cancelled()

    with pytest.raises(Cancelled):
        cancellation.run(work)
    assert done == [0, 1, 2]
    with pytest.raises(Cancelled):
        cancellation.run(lambda: done.append("never"))  # requested before it began
    assert done == [0, 1, 2]
    check_cancelled()  # outside of any work it has no effect
    assert Cancellation().run(lambda: 5) == 5


@pytest.fixture(scope="module")
def drive(tmp_path_factory):
    return record(tmp_path_factory.mktemp("drive") / "drive.pcapng", count=40)


def test_every_reader_of_a_recording_can_be_cancelled(drive, tmp_path):
    """Its last check is late: in the second reading of the file, the one for the values."""

    def written(suffix):
        recording = Recording(drive, shipped())
        out = tmp_path / f"a{suffix}"
        export(out, recording.channels, recording.rows(), events=recording.events)

    readers = [
        lambda: summarise(drive, shipped()),
        lambda: Recording(drive, shipped()).window(0, 1e12),
        lambda: find_in_recording(mikas.open(drive)),
        lambda: written(".csv"),
        lambda: written(".parquet"),  # it has a temporary folder
    ]
    for number, reader in enumerate(readers):
        counting = AfterChecks(10_000)
        counting.run(reader)
        checks = 10_000 - counting.left
        assert checks > 5, number
        for out in tmp_path.iterdir():
            out.unlink()
        with pytest.raises(Cancelled):
            AfterChecks(checks - 1).run(reader)  # at its very last check
        assert list(tmp_path.iterdir()) == []  # no half file, no temporary folder
