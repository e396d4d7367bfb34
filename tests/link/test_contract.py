"""The contract over the links that every system has. A pty is in `posix`."""

from __future__ import annotations

import pytest

from mikas.link import CaptureTee
from mikas.testing.links import RealTimeContract, Rig

from .rigs import asked_rig, rfc2217_rig, tcp_rig

pytestmark = pytest.mark.realtime


class Forgetful:
    def record(self, direction, data, time):
        """Keep nothing."""


def teed(rig: Rig) -> Rig:
    return Rig(CaptureTee(rig.link, Forgetful()), rig.peer)


class TestAskedPort(RealTimeContract):
    can_set_baud = True

    @pytest.fixture
    def rig(self):
        with asked_rig() as rig:
            yield rig


class TestSocket(RealTimeContract):
    can_set_baud = False
    can_break = False
    gathers = False

    @pytest.fixture
    def rig(self):
        with tcp_rig() as rig:
            yield rig


class TestRfc2217(RealTimeContract):
    can_set_baud = True
    gathers = False

    @pytest.fixture
    def rig(self):
        with rfc2217_rig() as rig:
            yield rig


class TestTeeOverAskedPort(RealTimeContract):
    @pytest.fixture
    def rig(self):
        with asked_rig() as rig:
            yield teed(rig)


class TestTeeOverSocket(RealTimeContract):
    can_break = False
    gathers = False

    @pytest.fixture
    def rig(self):
        with tcp_rig() as rig:
            yield teed(rig)
