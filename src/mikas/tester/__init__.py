"""Reliable requests and responses on one wire (D1, D2, D11–D14)."""

from mikas.tester.handshake import Echo
from mikas.tester.statistics import Failure, Statistics
from mikas.tester.stream import Stream, StreamItem
from mikas.tester.tester import Tester
from mikas.tester.timing import Reply, Timing

__all__ = ["Echo", "Failure", "Reply", "Statistics", "Stream", "StreamItem", "Tester", "Timing"]
