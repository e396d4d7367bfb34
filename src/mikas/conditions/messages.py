"""Publishes what has happened to an MQTT broker: a message for each action.

The topic is `BASE/NAME`, `BASE/availability` says whether this program runs. While the broker is
away the latest thousand messages are kept (`mikas.publish.outbox`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final
from urllib.parse import quote

from mikas.conditions.loading import LoadedActions
from mikas.i18n import Text
from mikas.publish.broker import parse_address, with_credentials, with_tls
from mikas.publish.connection import BrokerChange, BrokerConnection, check_library
from mikas.publish.outbox import Message, MessageKind, Outbox
from mikas.publish.topics import Topics

DEFAULT_TOPIC: Final = "mikas/actions"


class ActionMessages:
    """The connection to the broker of `actions`. `on_failure` is called in its thread.

    User name and password come from the address or the environment, as of `mikas publish`. Raises
    `UsageError` for an address or a topic that is none, `MissingExtra` without the library.
    """

    def __init__(self, actions: LoadedActions, on_failure: Callable[[Text], object]) -> None:
        check_library()
        self._topics = Topics(actions.topic or DEFAULT_TOPIC)
        self._on_failure = on_failure
        broker = with_tls(with_credentials(parse_address(actions.broker)))
        online, offline = (
            Message(self._topics.availability, word, MessageKind.RETAINED)
            for word in (b"online", b"offline")
        )
        self._connection = BrokerConnection(
            broker,
            Outbox(),
            client_id=self._topics.identifier,
            online=online,
            offline=offline,
            on_change=self._changed,
        )
        self._connection.open(patient=True)

    def send(self, name: str, body: bytes, time: float) -> None:
        """Publish the JSON `body` for the action `name`; never waits."""
        topic = f"{self._topics.base}/{quote(name, safe='')}"
        self._connection.send([Message(topic, body, MessageKind.EVENT, time=time)])

    def close(self) -> None:
        """Send the last messages; two seconds at most."""
        self._connection.close()

    def _changed(self, change: BrokerChange) -> None:
        if change.error is not None:
            self._on_failure(change.error.text)
