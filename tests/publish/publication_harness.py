"""A session on simulated time: its events, and the messages made of each."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass, field

from mikas.catalog import shipped
from mikas.client.connecting import ConnectionOptions
from mikas.link.reconnecting import ReconnectingPort
from mikas.publish.outbox import Message
from mikas.publish.publication import Publication
from mikas.publish.topics import Topics
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.events import Event
from mikas.sampling.session import SamplingSession

CATALOG = shipped()
TOPICS = Topics("garage/volga")


def publication(*names: str, **options: object) -> Publication:
    """Return a publication of these channels."""
    channels = [CATALOG.channel(name) for name in names]
    return Publication(TOPICS, CATALOG, channels, **options)


def drive(
    settings: str, *names: str, seconds: float, method: str = "batch", rate: float | None = None
) -> Iterator[Event]:
    """Yield the events of a virtual car, with readings of its faults, as the command does."""
    acquisition = Acquisition(
        ReconnectingPort(f"sim:?clock=simulated{settings}"),
        ConnectionOptions(catalog=CATALOG).create_ecu,
        CATALOG,
        names,
        method=method,
        rate=rate,
    )
    with closing(SamplingSession().run(acquisition)) as events:
        for event in events:
            yield event
            if event.time > seconds:
                return


@dataclass
class Published:
    """Events, each with its messages, and the messages of one topic as Python values."""

    steps: list[tuple[Event, list[Message]]] = field(default_factory=list)

    @classmethod
    def of(cls, events: Iterator[Event], made: Publication) -> Published:
        """Return what `made` publishes of the events."""
        return cls([(event, made.messages_of(event)) for event in events])

    @property
    def messages(self) -> list[Message]:
        return [message for _, messages in self.steps for message in messages]

    def under(self, topic: str) -> list[dict]:
        """Return the JSON of each message of `garage/volga/TOPIC`."""
        return [content(it) for it in self.messages if it.topic == f"{TOPICS.base}/{topic}"]


def content(message: Message) -> dict:
    return json.loads(message.payload)
