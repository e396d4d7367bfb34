"""Reads `actions.toml`: rules by name, and the broker of their messages.

A mistake is a `CatalogError` with file and line. A file has at most fifty rules; its size is
bounded before it is parsed (`mikas.toml`). A channel that does not exist is a mistake, too, unless
the program's instruments come and go: then the rule rests, and the others act.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from string import Formatter
from typing import Any, Final, TypeAlias

from mikas.catalog import Catalog
from mikas.catalog.formula_syntax import Parsed, parse
from mikas.catalog.loading.build import does_not_exist
from mikas.catalog.loading.fields import Schema, made, read_table, schema_of, string
from mikas.catalog.loading.source import CatalogFile, KeyPath, parse_source, read_source
from mikas.catalog.model import in_order
from mikas.conditions.addresses import check_webhook
from mikas.conditions.definition import LONGEST_WORDS, MOST_RULES, ActionRule
from mikas.errors import UnknownParameter, UsageError
from mikas.i18n import Text

_NAME: Final = re.compile(r"[\w-]{1,40}")
_BROKER: Schema = {"broker": string, "topic": string}
_WRONG_NAME: Final = Text(
    "is no name of up to 40 letters, digits, _ and -", "имя — до 40 букв, цифр, _ и -"
)
_TOO_MANY: Final = Text(f"has more than {MOST_RULES} rules", f"больше {MOST_RULES} правил")
_NOTHING: Final = Text(
    "does nothing: add mark, record, sound, speak, mqtt or webhook",
    "ничего не делает: добавьте mark, record, sound, speak, mqtt или webhook",
)
_NO_WHEN: Final = Text("has no `when`", "нет `when`")
_NO_BROKER: Final = Text(
    'needs the address of a broker: [mqtt] with broker = "mqtt://HOST"',
    'нужен адрес брокера: [mqtt] с broker = "mqtt://HOST"',
)
_BRACES: Final = Text("has a single brace", "содержит одиночную скобку")
_NAME_ALONE: Final = Text(
    "has braces with other things than a channel's name: write {TWAT}, which gives the value with "
    "the digits and the unit of the channel",
    "содержит в скобках не только имя канала: пишите {TWAT}, значение подставится с единицей и "
    "точностью канала",
)
_LONG: Final = Text(f"is longer than {LONGEST_WORDS} characters", f"длиннее {LONGEST_WORDS} знаков")


@dataclass(frozen=True, slots=True)
class LoadedActions:
    """The rules of a file, and where their messages go."""

    rules: tuple[ActionRule, ...] = ()
    """The rules, in the order of the file."""
    resting: frozenset[str] = frozenset()
    """The names of those that name a channel which does not exist now."""
    broker: str = ""
    """The address of the MQTT broker; empty: there is none."""
    topic: str = ""
    """The topic below which the messages are; empty: `mikas/actions`."""

    @property
    def acting(self) -> tuple[ActionRule, ...]:
        """The rules that do not rest."""
        return tuple(rule for rule in self.rules if rule.name not in self.resting)


MayRest: TypeAlias = Callable[[str], bool]
"""Whether a rule may rest that names this channel, which does not exist now."""


def _never(_: str) -> bool:
    return False


def load_actions(path: Path, catalog: Catalog, may_rest: MayRest = _never) -> LoadedActions:
    """Return the rules in a file. Raises `CatalogError` with its line."""
    return _Builder(read_source(path), catalog, may_rest).actions()


def read_actions(name: str, text: str, catalog: Catalog) -> LoadedActions:
    """Return the rules in the text of the file `name`. Raises `CatalogError`."""
    return _Builder(parse_source(name, text.encode("utf-8", "surrogatepass")), catalog).actions()


def actions_in(
    tables: Mapping[str, Any], catalog: Catalog, may_rest: MayRest = _never
) -> LoadedActions:
    """Return the rules in the tables of a file that does not exist yet. Raises `CatalogError`."""
    return _Builder(CatalogFile("actions.toml", "", dict(tables)), catalog, may_rest).actions()


class _Builder:
    def __init__(self, source: CatalogFile, catalog: Catalog, may_rest: MayRest = _never) -> None:
        self._source, self._catalog, self._may_rest = source, catalog, may_rest
        self._resting = False  # the rule that is built
        schema: Schema = {"action": {"*": schema_of(ActionRule)}, "mqtt": _BROKER}
        self._form = read_table(source, (), source.tables, schema)

    def actions(self) -> LoadedActions:
        tables: Mapping[str, Any] = self._form.get("action", {})
        if len(tables) > MOST_RULES:
            raise self._source.wrong(("action",), _TOO_MANY)
        mqtt = self._form.get("mqtt", {})
        broker, topic = mqtt.get("broker", ""), mqtt.get("topic", "")
        rules, resting = [], set()
        for name, keys in tables.items():
            self._resting = False
            rules.append(self._rule(name, keys))
            if self._resting:
                resting.add(name)
        for rule in rules:
            if rule.mqtt and not broker:
                raise self._source.wrong(("action", rule.name, "mqtt"), _NO_BROKER)
        return LoadedActions(tuple(rules), frozenset(resting), broker, topic)

    def _rule(self, name: str, keys: Mapping[str, Any]) -> ActionRule:
        path = ("action", name)
        if not _NAME.fullmatch(name):
            raise self._source.wrong(path, _WRONG_NAME)
        if not keys.get("when"):
            raise self._source.wrong(path, _NO_WHEN)
        condition = self._formula((*path, "when"), keys["when"])
        until = keys.get("until", "")
        texts = {
            key: self._text((*path, key), keys[key], condition) for key in _WORDS & keys.keys()
        }
        rule = made(
            ActionRule,
            {**keys, **texts},
            name=name,
            condition=condition,
            hold=keys.get("for", 0.0),
            release=self._formula((*path, "until"), until) if until else None,
        )
        if not rule.acts:
            raise self._source.wrong(path, _NOTHING)
        if rule.webhook:
            try:
                check_webhook(rule.webhook)
            except UsageError as error:
                raise self._source.wrong((*path, "webhook"), error.reason) from None
        return rule

    def _formula(self, path: KeyPath, text: str) -> Parsed:
        """Return the formula of channels at `path`; a sum over time is none of the moment."""
        try:
            parsed = parse(text, {}, self._catalog.input_of)
        except UsageError as error:
            raise self._source.wrong(path, error.reason) from None
        for name in parsed.inputs:
            try:
                self._catalog.formula_channel(name)
            except UnknownParameter:
                if not self._may_rest(name):
                    problem = does_not_exist(name, self._catalog.formula_channels)
                    raise self._source.wrong(path, problem) from None
                self._resting = True
        derived = self._catalog.derived
        for channel in in_order(derived, (name for name in parsed.inputs if name in derived)):
            if channel.accumulates:
                problem = Text(
                    f"needs {channel.name}, a total; a condition needs values of the moment",
                    f"опирается на {channel.name} — это сумма; условию нужны мгновенные значения",
                )
                raise self._source.wrong(path, problem)
        return parsed

    def _text(self, path: KeyPath, given: Mapping[str, str], condition: Parsed) -> Text:
        """Return a text; one language stands for both. Fields in braces are the condition's."""
        english, russian = given.get("en", ""), given.get("ru", "")
        text = Text(english or russian, russian or english)
        for words in text:
            if len(words) > LONGEST_WORDS:
                raise self._source.wrong(path, _LONG)
            try:
                fields = [part for part in Formatter().parse(words) if part[1] is not None]
            except ValueError:
                raise self._source.wrong(path, _BRACES) from None
            for _, name, form, conversion in fields:
                if not name or form or conversion:
                    raise self._source.wrong(path, _NAME_ALONE)
                if name not in condition.inputs:
                    raise self._source.wrong(path, _not_in_condition(name, condition.inputs))
        return text


def _not_in_condition(name: str, inputs: Sequence[str]) -> Text:
    there = ", ".join(f"{{{each}}}" for each in inputs)
    return Text(
        f"names {name}, which is not in `when`; there are: {there}",
        f"имени {name} нет в `when`; есть: {there}",
    )


_WORDS: Final = frozenset({"mark", "speak"})
