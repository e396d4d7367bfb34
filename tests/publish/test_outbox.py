"""The outbox: bounded, in order, and nothing lost without being counted."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from mikas.publish.outbox import Lost, Message, MessageKind, Outbox


def message(kind: MessageKind, number: int, topic: str = "t", size: int = 4) -> Message:
    rows = 3 if kind is MessageKind.SAMPLES else 0
    return Message(topic, f"{number:>{size}}".encode(), kind, time=float(number), rows=rows)


def sent_by(outbox: Outbox, most: int = 10**6) -> list[Message]:
    """What a connection sends that lasts for `most` messages."""
    sent = []
    while len(sent) < most and (following := outbox.next()) is not None:
        outbox.sent(following)
        sent.append(following)
    return sent


ACTIONS = st.lists(
    st.one_of(
        st.tuples(st.sampled_from(MessageKind), st.sampled_from("ab"), st.integers(4, 40)),
        st.sampled_from(["connect", "disconnect", "send"]),
    ),
    max_size=60,
)


@given(ACTIONS)
def test_every_sample_and_event_is_sent_waiting_or_counted_as_lost(actions):
    outbox = Outbox(most_events=5, most_bytes=100)
    put, sent, lost, connected = [], [], Lost(), False
    for number, action in enumerate(actions):
        if action == "connect":
            outbox.connected()
            once = outbox.take_lost()
            lost, connected = Lost(lost.samples + once.samples, lost.events + once.events), True
        elif action == "disconnect":
            outbox.disconnected()
            connected = False
        elif action == "send":
            if connected:
                sent += sent_by(outbox, most=3)
        else:
            kind, topic, size = action
            put.append(message(kind, number, topic, size))
            outbox.put([put[-1]])
    unsent = outbox.unsent
    assert not outbox.take_lost() or unsent
    assert outbox.unsent.events <= 5  # what is still there
    outbox.connected()
    for kind, count, rows in (
        (MessageKind.EVENT, lost.events + unsent.events, 1),
        (MessageKind.SAMPLES, lost.samples + unsent.samples, 3),
    ):
        there = [it for it in put if it.kind is kind]
        gone = [it for it in sent if it.kind is kind]
        assert len(there) * rows == len(gone) * rows + count
        numbers = [int(it.payload) for it in gone]
        assert numbers == sorted(set(numbers))  # in order, none twice
    # The latest of each retained topic is sent now, whatever was sent before; the rest behind it.
    latest = {it.topic: it for it in put if it.kind is MessageKind.RETAINED}
    rest = sent_by(outbox)
    assert {it.topic: it for it in rest[: len(latest)]} == latest
    assert sum(len(it.payload) for it in rest if it.kind is MessageKind.SAMPLES) <= 100


def test_values_of_an_outage_are_not_sent_later():
    outbox = Outbox()
    outbox.put([message(MessageKind.LIVE, 1)])
    outbox.connected()
    assert outbox.next() is None
    outbox.put([message(MessageKind.LIVE, 2), message(MessageKind.LIVE, 3)])
    assert [it.payload for it in sent_by(outbox)] == [b"   3"]  # the latest alone
    outbox.put([message(MessageKind.LIVE, 4)])
    outbox.disconnected()
    outbox.connected()
    assert outbox.next() is None


def test_a_message_that_was_replaced_while_it_was_sent_stays():
    outbox = Outbox()
    outbox.put([message(MessageKind.RETAINED, 1)])
    outbox.connected()
    first = outbox.next()
    outbox.put([message(MessageKind.RETAINED, 2)])
    outbox.sent(first)
    assert outbox.next().payload == b"   2"


def test_what_was_lost_has_its_first_and_last_time():
    outbox = Outbox(most_bytes=8)
    outbox.put(message(MessageKind.SAMPLES, number) for number in range(5))
    outbox.connected()
    assert outbox.take_lost() == Lost(samples=9, since=0.0, until=2.0)
    assert not outbox.take_lost()


def test_samples_begin_with_their_first_row_and_events_may_be_older():
    outbox = Outbox()
    rows = Message("t", b"", MessageKind.SAMPLES, time=90.0, since=30.0, rows=3)
    outbox.put([rows, message(MessageKind.EVENT, 40), message(MessageKind.EVENT, 20)])
    assert outbox.unsent == Lost(samples=3, events=2, since=20.0, until=90.0)


def test_what_had_no_room_is_unsent_too_until_it_was_reported():
    outbox = Outbox(most_events=2)
    outbox.put(message(MessageKind.EVENT, number) for number in range(5))
    outbox.connected()
    outbox.disconnected()
    assert outbox.unsent.events == 5
    assert outbox.take_lost().events == 3
    assert outbox.unsent.events == 2


def test_samples_stand_behind_all_others():
    outbox = Outbox()
    outbox.connected()
    outbox.put(message(kind, 1, kind.name) for kind in reversed(MessageKind))
    assert [it.kind for it in sent_by(outbox)] == list(MessageKind)
