"""Performs what a rule says, with what the program has: a recorder, a bell, a voice, a network.

What it lacks is named once, at the begin (`lacking`), so that no rule is silently
without effect. A failure of a webhook or a broker is said, and stops nothing.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from mikas.catalog import Catalog
from mikas.conditions.definition import ActionRule, RecordAction
from mikas.conditions.evaluation import Fired
from mikas.conditions.loading import LoadedActions
from mikas.i18n import Text
from mikas.recording.formatting import quantity

if TYPE_CHECKING:
    from mikas.conditions.messages import ActionMessages
    from mikas.conditions.webhooks import Webhooks

SCHEMA: Final = 1
_NONE: Final = Text("–", "–")


@dataclass(frozen=True, slots=True)
class Hands:
    """What the program can do; None: it can't.

    `network`: whether it has one for MQTT and webhooks: not so in a browser.
    """

    mark: Callable[[Text], object] | None = None
    """Sets a marker of that name."""
    start: Callable[[], object] | None = None
    """Starts a recording, if none runs."""
    stop: Callable[[], object] | None = None
    """Stops the recording, if one runs."""
    sound: Callable[[], object] | None = None
    """Makes a sound."""
    speak: Callable[[Text], object] | None = None
    """Says a text."""
    network: bool = True


class ActionRunner:
    """Performs the rules of `actions` with `hands`; a context manager.

    `on_failure` gets a sentence, perhaps in another thread. `later`: the seconds that the date is
    later than the link's clock. Raises `UsageError` for a webhook that is not on this computer or a
    wrong broker, `MissingExtra` without the library for MQTT.
    """

    def __init__(
        self,
        actions: LoadedActions,
        catalog: Catalog,
        hands: Hands,
        on_failure: Callable[[Text], object],
        later: Callable[[], float] = lambda: 0.0,
    ) -> None:
        self._catalog, self._hands, self._later = catalog, hands, later
        self._messages: ActionMessages | None = None
        self._webhooks: Webhooks | None = None
        rules = actions.rules if hands.network else ()
        urls = [rule.webhook for rule in rules if rule.webhook]
        if urls:
            from mikas.conditions.webhooks import Webhooks

            self._webhooks = Webhooks(urls, on_failure)
        if any(rule.mqtt for rule in rules):
            from mikas.conditions.messages import ActionMessages

            self._messages = ActionMessages(actions, on_failure)

    def perform(self, fired: Fired, *, recording: bool = True) -> None:
        """Do what the rule says; without `recording` none is started or stopped: a trial."""
        rule, hands = fired.rule, self._hands
        if rule.mark and hands.mark:
            hands.mark(self.filled(rule.mark, fired))
        if recording and rule.record is RecordAction.START and hands.start:
            hands.start()
        if recording and rule.record is RecordAction.STOP and hands.stop:
            hands.stop()
        if rule.sound and hands.sound:
            hands.sound()
        if rule.speak and hands.speak:
            hands.speak(self.filled(rule.speak, fired))
        body = json.dumps(self._content(fired), ensure_ascii=False).encode()
        if rule.mqtt and self._messages:
            self._messages.send(rule.name, body, fired.time + self._later())
        if rule.webhook and self._webhooks:
            self._webhooks.send(rule.webhook, body)

    def filled(self, text: Text, fired: Fired) -> Text:
        """Return a text with the values of its channels, with their units; a dash for none."""
        shown = {
            name: quantity(fired.values[name], self._catalog.formula_channel(name))
            if name in fired.values
            else _NONE
            for name in fired.rule.condition.inputs
        }
        return text.filled(**shown)

    def close(self) -> None:
        """Send what waits, for some seconds at most."""
        if self._messages is not None:
            self._messages.close()
        if self._webhooks is not None:
            self._webhooks.close()

    def __enter__(self) -> ActionRunner:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _content(self, fired: Fired) -> dict[str, object]:
        later = self._later()
        return {
            "schema": SCHEMA,
            "action": fired.rule.name,
            "time": round(fired.time + later, 6),
            "since": round(fired.since + later, 6),
            "when": fired.rule.when,
            "values": dict(fired.values),
        }


def lacking(rules: tuple[ActionRule, ...], hands: Hands) -> Iterator[tuple[str, str]]:
    """Yield the name and the key of each rule that `hands` can't do."""
    for rule in rules:
        if rule.mark and hands.mark is None:
            yield rule.name, "mark"
        if rule.record is RecordAction.START and hands.start is None:
            yield rule.name, 'record = "start"'
        if rule.record is RecordAction.STOP and hands.stop is None:
            yield rule.name, 'record = "stop"'
        if rule.sound and hands.sound is None:
            yield rule.name, "sound"
        if rule.speak and hands.speak is None:
            yield rule.name, "speak"
        if rule.mqtt and not hands.network:
            yield rule.name, "mqtt"
        if rule.webhook and not hands.network:
            yield rule.name, "webhook"
