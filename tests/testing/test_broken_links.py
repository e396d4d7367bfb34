"""The links' contract on a link that keeps none of it: each failure says what to do."""

from __future__ import annotations

import pytest

from mikas.link import Chunk, Link
from mikas.testing import links
from mikas.testing.links import LinkContract, Rig


class Broken(Link):
    """Loses a byte, returns at once, stamps wrong times, never closes; its clock may stand."""

    url = "broken:"
    is_simulated = True

    def __init__(self):
        self.inbox, self.sent, self.time = bytearray(), bytearray(), 0.0

    def write(self, data):
        self.sent += data.replace(b"\n", b"")

    def read(self, deadline):
        data = bytes(self.inbox)
        self.inbox.clear()
        return Chunk(data, self.time + 5)

    def now(self):
        return self.time

    def send_break(self, seconds):
        pass

    def set_baud(self, baud):
        return True

    def close(self):
        pass


class Peer:
    def __init__(self, link):
        self.link = link

    def send(self, data):
        self.link.inbox += data

    def received(self, count):
        data = bytes(self.link.sent)
        self.link.sent.clear()
        return data

    def vanish(self):
        pass


@pytest.fixture
def rig(monkeypatch):
    monkeypatch.setattr(
        links, "FAR", 0.01
    )  # s: a link whose clock stands is written to for so long
    link = Broken()
    return Rig(link, Peer(link))


@pytest.mark.parametrize(
    ("test", "advice"),
    [
        ("what_is_written_arrives_unchanged", "let write() send every byte as it is"),
        ("a_read_does_not_wait_for_its_deadline_once_something_arrived", "let Chunk.time be"),
        ("silence_gives_an_empty_chunk_at_the_deadline_and_not_earlier", "let read() wait until"),
        ("what_gathers_meanwhile_is_there_afterwards", "or set `gathers = False`"),
        ("a_loss_does_not_show_while_bytes_gather", "read() after close() raised nothing; let it"),
        ("a_break_takes_its_time_and_leaves_the_link_usable", "let send_break() last as long"),
        ("the_baud_rate_changes_or_stays_as_it_was", "let `baud` follow set_baud()"),
        ("leaving_its_context_closes_it", "raised nothing; let it raise mikas.errors.LinkLost("),
        ("a_vanished_adapter_ends_the_read_and_stays_lost", "let it wait until then"),
        ("a_vanished_adapter_takes_no_bytes", "raised nothing; let it raise"),
    ],
)
def test_a_failure_says_what_to_do(rig, test, advice):
    with pytest.raises((AssertionError, pytest.fail.Exception)) as caught:
        getattr(LinkContract(), f"test_{test}")(rig)
    assert advice in str(caught.value)


def test_another_error_than_a_loss_is_named(rig, monkeypatch):
    def failing(deadline):
        raise OSError("of the system")

    monkeypatch.setattr(rig.link, "read", failing)
    with pytest.raises(
        AssertionError, match=r"read\(\) after close\(\) raised OSError \(of the sys"
    ):
        LinkContract().test_a_closed_link_is_lost(rig, "read")
