"""Reliable requests and responses on one wire (D1, D2, D11–D14)."""

from mikas.tester.exchange import Failure, Reply, Statistics, Timing
from mikas.tester.handshake import Echo
from mikas.tester.stream import Stream, StreamItem
from mikas.tester.tester import Tester

__all__ = ["Echo", "Failure", "Reply", "Statistics", "Stream", "StreamItem", "Tester", "Timing"]
