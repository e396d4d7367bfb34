"""Writes rules as TOML, so that a screen can edit the file that a person can, too."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator

from mikas.conditions.definition import ActionRule
from mikas.conditions.loading import LoadedActions
from mikas.i18n import Text


def actions_toml(actions: LoadedActions) -> str:
    """Return the text of a file with these rules; `read_actions` gives the same back."""
    parts = []
    if actions.broker or actions.topic:
        keys = {"broker": actions.broker, "topic": actions.topic}
        parts.append(_table("mqtt", [(key, _string(it)) for key, it in keys.items() if it]))
    parts += [_table(f"action.{_string(rule.name)}", _keys(rule)) for rule in actions.rules]
    return "\n".join(parts)


def _table(header: str, keys: Iterable[tuple[str, str]]) -> str:
    return f"[{header}]\n" + "".join(f"{key} = {value}\n" for key, value in keys)


def _keys(rule: ActionRule) -> Iterator[tuple[str, str]]:
    yield "when", _string(rule.when)
    if rule.hold:
        yield "for", _number(rule.hold)
    if rule.until:
        yield "until", _string(rule.until)
    if rule.again:
        yield "again", _number(rule.again)
    for key in ("once", "sound", "mqtt"):
        if getattr(rule, key):
            yield key, "true"
    if rule.record:
        yield "record", _string(rule.record.value)
    for key, text in (("mark", rule.mark), ("speak", rule.speak)):
        if text:
            yield key, _text(text)
    if rule.webhook:
        yield "webhook", _string(rule.webhook)


def _text(text: Text) -> str:
    if text.en == text.ru:
        return _string(text.en)
    return f"{{ en = {_string(text.en)}, ru = {_string(text.ru)} }}"


def _number(value: float) -> str:
    return repr(int(value)) if float(value).is_integer() else f"{value:.6f}".rstrip("0")


def _string(text: str) -> str:
    """Return a basic string: JSON's escapes are TOML's, which also wants DEL escaped."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
