"""What every link promises (`mikas.link.base.Link`), as one suite to run over each of them.

    import pytest
    from mikas.testing.links import LinkContract, Rig

    class TestMine(LinkContract):
        can_break = False

        @pytest.fixture
        def rig(self):
            with open_mine() as link:
                yield Rig(link, MyPeer(...))

A class inherits `LinkContract`, or `RealTimeContract` if its waits are real, names its quirks as
class attributes, and has a fixture `rig`: the open link and the other end of its wire.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Protocol

import pytest

from mikas.errors import LinkLost
from mikas.link import Link
from mikas.link.base import AwaitedAnswer

EVERY_BYTE = bytes(range(256))
SOON = 0.02
FAR = 30.0
_LOST = "mikas.errors.LinkLost(url=link.url, problem=…)"


class Peer(Protocol):
    """The other end of the wire."""

    def send(self, data: bytes) -> None:
        """Let `data` arrive at the link, at once or as time passes."""

    def received(self, count: int) -> bytes:
        """Return what the link sent since the last call, once it is `count` bytes."""

    def vanish(self) -> None:
        """Pull the plug."""


@dataclass
class Rig:
    """An open link, and the other end of its wire."""

    link: Link
    """The open link."""
    peer: Peer
    """The other end of its wire."""


def collect(link: Link, count: int) -> bytes:
    """Read until `count` bytes have come, or a long time has passed."""
    data = b""
    deadline = link.now() + FAR
    while len(data) < count and link.now() < deadline:
        chunk = link.read(deadline)
        data += chunk.data
        if not chunk.data and link.now() < deadline:
            pytest.fail(
                "read() returned an empty chunk before its deadline; let it wait until then"
            )
    return data


def for_long(link: Link) -> Iterator[None]:
    """Iterate for a long time of the link's clock, or of this computer's if that stands still."""
    deadline, last = link.now() + FAR, time.monotonic() + FAR
    while link.now() < deadline and time.monotonic() < last:
        yield


def write_until_lost(link: Link, data: bytes, between: Callable[[], None] = lambda: None) -> None:
    """Write `data` again and again: for a loss that need not show at the first write."""
    for _ in for_long(link):
        link.write(data)
        between()


@contextmanager
def lost(doing: str) -> Iterator[list[LinkLost]]:
    """Fail unless the block raises `LinkLost`; the list has the error then."""
    caught: list[LinkLost] = []
    try:
        yield caught
    except LinkLost as error:
        caught.append(error)
        return
    except Exception as error:  # whatever the link raises instead
        why = f"{doing} raised {type(error).__name__} ({error}); let it raise {_LOST}"
        raise AssertionError(why) from error
    pytest.fail(f"{doing} raised nothing; let it raise {_LOST}")


@contextmanager
def meanwhile(act: Callable[[], object]) -> Iterator[None]:
    """Do `act` in another thread, and wait for its end."""
    thread = threading.Thread(target=act)
    thread.start()
    try:
        yield
    finally:
        thread.join()


class LinkContract:
    """For every link."""

    can_break = True
    """Whether the link pulls the wire low."""
    can_set_baud: bool | None = None
    """Whether `set_baud` changes the rate of the open port; None: either is right."""
    gathers = True
    """Whether `gather` sleeps, so that bytes come together."""

    def test_names_what_it_is(self, rig: Rig) -> None:
        assert rig.link.url, "give the link a `url`: its name in messages"
        assert rig.link.description, "let `description` be a name; by default it is the url"

    def test_a_byte_is_ten_bits(self, rig: Rig) -> None:
        assert rig.link.byte_time == pytest.approx(10 / rig.link.baud), (
            "set `baud` to the bits a second on the wire, and leave `byte_time`"
        )

    def test_what_is_written_arrives_unchanged(self, rig: Rig) -> None:
        rig.link.write(EVERY_BYTE)
        assert rig.peer.received(256) == EVERY_BYTE, "let write() send every byte as it is"

    def test_writes_keep_their_order(self, rig: Rig) -> None:
        for value in b"\x01\xff\r":
            rig.link.write(bytes([value]))
        assert rig.peer.received(3) == b"\x01\xff\r", "let write() keep the order"

    def test_writing_nothing_does_nothing(self, rig: Rig) -> None:
        rig.link.write(b"")
        rig.link.write(b"x")
        assert rig.peer.received(1) == b"x", "let write(b'') do nothing"

    def test_what_is_sent_here_is_read_unchanged(self, rig: Rig) -> None:
        rig.peer.send(EVERY_BYTE)
        assert collect(rig.link, 256) == EVERY_BYTE, "let read() return every byte as it came"

    def test_a_read_does_not_wait_for_its_deadline_once_something_arrived(self, rig: Rig) -> None:
        began = rig.link.now()
        rig.peer.send(b"\x09")
        chunk = rig.link.read(began + FAR)
        assert chunk.data == b"\x09", "let read() return the byte that has come"
        assert began <= chunk.time <= rig.link.now(), (
            "let Chunk.time be the link's clock when the last byte was seen"
        )
        assert rig.link.now() < began + FAR / 2, "let read() return once something has come"

    def test_silence_gives_an_empty_chunk_at_the_deadline_and_not_earlier(self, rig: Rig) -> None:
        deadline = rig.link.now() + SOON
        chunk = rig.link.read(deadline)
        assert chunk.data == b"", "let read() return no byte that was not sent"
        assert deadline <= rig.link.now() < deadline + FAR / 2, (
            "let read() wait until the deadline of the link's clock, and no longer"
        )
        assert deadline <= chunk.time <= rig.link.now(), (
            "let Chunk.time of an empty chunk be the link's clock when the wait ended"
        )

    def test_a_deadline_in_the_past_does_not_wait(self, rig: Rig) -> None:
        before = rig.link.now()
        assert rig.link.read(before - FAR).data == b""
        assert rig.link.now() < before + FAR / 2, "let read() not wait for a deadline in the past"

    def test_a_deadline_in_the_past_still_looks(self, rig: Rig) -> None:
        rig.peer.send(b"\x0a")
        assert rig.link.read(rig.link.now() + FAR).data == b"\x0a"
        rig.peer.send(b"\x09")
        data = b""
        for _ in for_long(rig.link):
            data = rig.link.read(rig.link.now() - 1).data
            if data:
                break
            self.let_time_pass(rig.link)
        assert data == b"\x09", "let read() return what is there, also if the deadline is past"

    def let_time_pass(self, link: Link) -> None:
        """For a simulated clock, which stands still between reads: move it on, reading nothing."""

    def test_what_gathers_meanwhile_is_there_afterwards(self, rig: Rig) -> None:
        rig.peer.send(b"\x09\xf7\r")
        until = rig.link.now() + SOON
        rig.link.gather(until)
        assert (rig.link.now() >= until) is self.gathers, (
            "let gather() sleep until the time that it gets, or set `gathers = False`"
        )
        assert collect(rig.link, 3) == b"\x09\xf7\r", "let gather() take no bytes from read()"

    def test_gathering_until_a_time_that_is_over_does_not_wait(self, rig: Rig) -> None:
        before = rig.link.now()
        rig.link.gather(before - FAR)
        assert rig.link.now() < before + FAR / 2, "let gather() not wait for a time that is over"

    def test_a_loss_does_not_show_while_bytes_gather(self, rig: Rig) -> None:
        rig.link.close()
        rig.link.gather(rig.link.now() + SOON)
        with lost("read() after close()"):
            rig.link.read(rig.link.now())

    def test_the_clock_never_runs_back(self, rig: Rig) -> None:
        times = []
        for _ in range(200):
            times += [rig.link.now(), rig.link.read(rig.link.now()).time]
        assert times == sorted(times), "take the time from mikas.link.WallClock: it never runs back"

    def test_a_link_writes_what_follows_an_answer_itself_or_says_that_it_can_not(
        self, rig: Rig
    ) -> None:
        rig.link.write(b"\x01\xff\r")
        assert rig.peer.received(3) == b"\x01\xff\r"
        if not rig.link.write_after(AwaitedAnswer(b"\x01\xff\r", 1), b"\x63\x9d\r"):
            assert rig.link.take_back() is None, "leave take_back() as it is in Link"
            return
        began = rig.link.now()
        rig.peer.send(b"\x01\xff\r\x09\xf7\r")
        assert rig.peer.received(3) == b"\x63\x9d\r", "let write_after() write after the answer"
        rig.peer.send(b"c")
        assert collect(rig.link, 6) == b"\x01\xff\r\x09\xf7\r", "keep what comes then"
        written = rig.link.take_back()
        assert written is not None, "let take_back() return when it was written"
        assert began <= written <= rig.link.now(), "let take_back() return when it was written"
        assert collect(rig.link, 1) == b"c", "let read() return what came then after take_back()"
        assert rig.link.take_back() is None

    def test_what_was_taken_back_is_not_written(self, rig: Rig) -> None:
        if not rig.link.write_after(AwaitedAnswer(b"\x01\xff\r", 1), b"\x63\x9d\r"):
            return
        assert rig.link.take_back() is None
        rig.link.write(b"\x01\xff\r")
        rig.peer.send(b"\x01\xff\r\x09\xf7\r")
        assert collect(rig.link, 6) == b"\x01\xff\r\x09\xf7\r"
        rig.link.write(b"x")
        assert rig.peer.received(4) == b"\x01\xff\rx", "let take_back() end write_after()"

    def test_a_break_takes_its_time_and_leaves_the_link_usable(self, rig: Rig) -> None:
        before = rig.link.now()
        rig.link.send_break(SOON)
        assert before + SOON <= rig.link.now() < before + FAR / 2, (
            "let send_break() last as long as it is said, also where the port can't do it"
        )
        assert rig.link.can_break is self.can_break, (
            "set the test's `can_break` to what the link's `can_break` is after send_break()"
        )
        rig.link.write(b"x")
        assert rig.peer.received(1)[-1:] == b"x", "let the link work on after send_break()"

    def test_the_baud_rate_changes_or_stays_as_it_was(self, rig: Rig) -> None:
        usual = rig.link.baud
        can = rig.link.set_baud(10_400)
        if self.can_set_baud is not None:
            assert can is self.can_set_baud, "let set_baud() return what `can_set_baud` says"
        assert rig.link.baud == (10_400 if can else usual), "let `baud` follow set_baud()"
        assert rig.link.byte_time == 10 / rig.link.baud, "leave byte_time as it is in Link"
        assert rig.link.set_baud(usual) is can, "let set_baud() go back to the first rate"
        assert rig.link.baud == usual, "let `baud` follow set_baud()"
        rig.link.write(b"x")
        assert rig.peer.received(1)[-1:] == b"x", "let the link work on after set_baud()"

    @pytest.mark.parametrize("use", ["read", "write", "send_break"])
    def test_a_closed_link_is_lost(self, rig: Rig, use: str) -> None:
        rig.link.close()
        with lost(f"{use}() after close()") as caught:
            self._use(rig.link, use)
        assert caught[0].fields["url"] == rig.link.url, f"let {use}() raise {_LOST}"

    def test_closing_twice_is_closing_once(self, rig: Rig) -> None:
        rig.link.close()
        rig.link.close()

    def test_a_closed_link_still_knows_the_time(self, rig: Rig) -> None:
        before = rig.link.now()
        rig.link.close()
        assert rig.link.now() >= before, "let now() work on a closed link, too"

    def test_a_closed_link_still_knows_the_date(self, rig: Rig) -> None:
        rig.link.close()
        now = rig.link.now() if rig.link.is_simulated else time.time()
        assert rig.link.date() == pytest.approx(now, abs=60), "leave date() as it is in Link"

    def test_leaving_its_context_closes_it(self, rig: Rig) -> None:
        with rig.link as link:
            assert link is rig.link
        with lost("read() after the end of `with`"):
            rig.link.read(rig.link.now())

    def test_a_vanished_adapter_ends_the_read_and_stays_lost(self, rig: Rig) -> None:
        rig.peer.vanish()
        with lost("read() without an adapter"):
            collect(rig.link, 1)
        for use in ("read", "write", "send_break"):
            with lost(f"{use}() without an adapter, after a LinkLost,"):
                self._use(rig.link, use)
        rig.link.close()

    def test_a_vanished_adapter_takes_no_bytes(self, rig: Rig) -> None:
        rig.peer.vanish()
        with lost("write() without an adapter, again and again,"):
            write_until_lost(rig.link, b"\x01\xff\r", lambda: self.let_time_pass(rig.link))

    @staticmethod
    def _use(link: Link, use: str) -> None:
        if use == "read":
            link.read(link.now() + FAR)
        elif use == "write":
            link.write(b"\x01\xff\r")
        else:
            link.send_break(0.0)


class RealTimeContract(LinkContract):
    """For a link whose waits are real: another thread can act while it waits."""

    def test_its_clock_is_unix_time(self, rig: Rig) -> None:
        assert rig.link.now() == pytest.approx(time.time(), abs=2), (
            "take the time from mikas.link.WallClock: it is UNIX time"
        )

    def test_a_waiting_read_gets_what_comes(self, rig: Rig) -> None:
        with meanwhile(lambda: rig.peer.send(b"\x09")):
            assert rig.link.read(rig.link.now() + FAR).data == b"\x09", (
                "let read() return a byte that comes while it waits"
            )

    def test_a_waiting_read_ends_when_the_adapter_vanishes(self, rig: Rig) -> None:
        began = rig.link.now()
        with meanwhile(rig.peer.vanish), lost("a read() that waits"):
            rig.link.read(began + FAR)
        assert rig.link.now() < began + FAR / 2, "let a read() that waits end at once"

    def test_a_waiting_read_ends_when_another_thread_closes_the_link(self, rig: Rig) -> None:
        began = rig.link.now()
        with meanwhile(rig.link.close), lost("a read() that waits"):
            rig.link.read(began + FAR)
        assert rig.link.now() < began + FAR / 2, "let a read() that waits end at once"
