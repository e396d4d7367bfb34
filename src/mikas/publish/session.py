"""One session of publishing: the messages of its events, and the broker that gets them.

with Publisher(…) as publisher:      the broker is reached, or its error is raised
    for event in events:
        publisher.publish(event)     never waits for the broker
                                     at the end: the state is “stopped”, then “offline”
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Self

from mikas.publish.broker import Broker
from mikas.publish.connection import BrokerChange, BrokerConnection
from mikas.publish.home_assistant import HomeAssistant
from mikas.publish.outbox import Lost, Message, MessageKind, Outbox, json_payload, rounded
from mikas.publish.publication import Publication
from mikas.publish.topics import Topics
from mikas.sampling.events import Event, UnitFound


@dataclass(frozen=True, slots=True)
class Destination:
    """The broker, the topics, and the name by which the broker knows this client.

    `patient`: wait for the broker at the start, too.
    """

    broker: Broker
    topics: Topics
    client_id: str
    patient: bool = False


@dataclass(eq=False)
class Publisher:
    """Publishes the events of one session to `destination`. A context manager.

    `home_assistant`: makes the discovery. `on_change` is called in a thread of its own. Raises
    `MissingExtra`; a `NoBroker` on entry, unless the destination is waited for.
    """

    destination: Destination
    publication: Publication
    home_assistant: HomeAssistant | None = None
    on_change: Callable[[BrokerChange], None] = lambda _: None

    def __post_init__(self) -> None:
        self._unit: UnitFound | None = None
        self._time: float | None = None  # of the latest event
        self._outbox = Outbox()
        online, offline = (
            Message(self.destination.topics.availability, word, MessageKind.RETAINED)
            for word in (b"online", b"offline")  # this is the last will, too
        )
        self.connection: BrokerConnection = BrokerConnection(
            self.destination.broker,
            self._outbox,
            client_id=self.destination.client_id,
            online=online,
            offline=offline,
            on_change=self._changed,
            kept_topic=self.home_assistant.topic if self.home_assistant else None,
            on_kept=self._discovered_before,
        )

    def __enter__(self) -> Self:
        self._outbox.put(self.publication.begin())
        self._discover()
        try:
            self.connection.open(patient=self.destination.patient)
        except BaseException:
            self.connection.close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self._outbox.put(self.publication.last_messages(self._time))
        self.connection.close()

    def publish(self, event: Event) -> None:
        """Publish `event`."""
        self._time = event.time
        self.connection.send(self.publication.messages_of(event))
        if isinstance(event, UnitFound):
            self._unit = event
            self._discover()

    @property
    def unsent(self) -> Lost:
        """The samples and events that the broker has not got."""
        return self._outbox.unsent

    def _discover(self) -> None:
        if self.home_assistant is not None:
            self.connection.send([self.home_assistant.discovery(self._unit)])

    def _discovered_before(self, discovery: bytes) -> None:
        assert self.home_assistant is not None
        self.home_assistant = self.home_assistant.after(discovery)
        self._discover()

    def _changed(self, change: BrokerChange) -> None:
        if change.lost:
            self.connection.send([self._lost_message(change.lost)])
        self.on_change(change)

    def _lost_message(self, lost: Lost) -> Message:
        content = {
            "kind": "lost",
            "time": rounded(lost.until),
            "samples": lost.samples,
            "events": lost.events,
            "since": rounded(lost.since),
            "until": rounded(lost.until),
        }
        topic = self.destination.topics.event
        return Message(topic, json_payload(content), MessageKind.EVENT, time=lost.until)


def remove(destination: Destination, discovery: str) -> None:
    """Delete what the broker keeps under these topics, and the device of Home Assistant.

    `discovery`: its topic. Returns when the broker has confirmed all. Raises `MissingExtra` and a
    `NoBroker`.
    """
    empty = [
        Message(topic, b"", MessageKind.RETAINED)
        for topic in (discovery, *destination.topics.retained)
    ]
    outbox = Outbox()
    outbox.put(empty)
    connection = BrokerConnection(
        destination.broker,
        outbox,
        client_id=destination.client_id,
        online=empty[-1],
        offline=empty[-1],
    )
    try:
        connection.open()
    finally:
        connection.close()
