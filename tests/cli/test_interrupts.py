"""Ctrl-C at any moment: the command ends with 130, and Python reports no exception that it lost."""

from __future__ import annotations

import sys

import pytest

from link_rig import registered
from mikas.link.virtual import VirtualLink
from mikas.virtual.build import build_bus

POINTS = 12
COMMANDS = {
    "watch": ["watch", "FREQ", "--count", "30", "--json"],
    "watch-stream": ["watch", "FREQ", "--count", "30", "--method", "stream", "--json"],
    "log": ["log", "-o", "drive.pcapng", "--count", "30", "--json"],
    "test": ["test", "idle", "--duration", "3"],
    "doctor": ["doctor"],
    "scan": ["scan"],
    "dump": ["mem", "dump", "ram", "-o", "ram.bin", "--to", "30"],
    "read": ["read"],
    "faults": ["faults"],
}


class InterruptedLink(VirtualLink):
    """Raises KeyboardInterrupt in operations of these numbers, as a signal would there."""

    def __init__(self, at: tuple[int, ...]) -> None:
        super().__init__(build_bus({}))
        self._at = at
        self.operations = 0

    def _count(self) -> None:
        self.operations += 1
        if self.operations in self._at:
            raise KeyboardInterrupt

    def read(self, deadline):
        self._count()
        return super().read(deadline)

    def write(self, data):
        self._count()
        super().write(data)

    def gather(self, until):
        self._count()
        super().gather(until)


@pytest.mark.parametrize("command", COMMANDS)
def test_ctrl_c_at_any_moment_ends_a_command_without_a_lost_exception(
    command, mikas, monkeypatch, tmp_path
):
    lost: list[str] = []
    monkeypatch.setattr(sys, "unraisablehook", lambda it: lost.append(repr(it)))

    def ran(*at: int):
        link = InterruptedLink(at)
        for left in tmp_path.glob("*.*"):
            left.unlink()
        with registered("counted", lambda *_: link):
            return mikas(*COMMANDS[command], "--port", "counted:"), link

    _, link = ran()
    assert link.operations > 20
    for first in range(1, link.operations, max(1, link.operations // POINTS)):
        for again in (0, 1, 3):  # and once more, while the first one is ending the run
            result, _ = ran(first, first + again)
            assert not lost, (command, first, again)
            assert result.status == 130, (command, first, again, result.err)
            assert "Traceback" not in result.err
