"""A user's actions on conditions: a `CatalogError` at a line of the file, else rules that run.

Input: the file. Rules that load are written and read back as the same ones, and follow values that
rise and fall, with a gap in them; a text of what they do must have its values filled in.
"""

from __future__ import annotations

from typing import Final

from mikas.catalog import shipped
from mikas.conditions import ConditionWatch, actions_toml, read_actions
from mikas.conditions.performing import ActionRunner, Hands
from mikas.errors import CatalogError

WORDS: Final = (
    *("[action.a]\n", "[mqtt]\n", "when = ", "for = ", "until = ", "again = ", "once = true\n"),
    *("mark = ", "record = ", '"start"\n', "sound = true\n", "speak = ", "mqtt = true\n"),
    *("webhook = ", '"http://localhost:1/"\n', "broker = ", "en = ", "ru = ", "{TWAT}", "{", "}"),
    *("TWAT", "FREQ", "FUEL_FLOW", " > ", " and ", " / ", " ** ", "1e999"),
    "обороты".encode().decode("latin-1"),  # a character of a word is a byte of the file
)


def check(data: bytes) -> None:
    catalog = shipped()
    try:
        actions = read_actions("own.toml", data.decode("utf-8", "surrogateescape"), catalog)
    except CatalogError as error:
        _check_error(error, data)
        return
    assert read_actions("own.toml", actions_toml(actions), catalog) == actions
    watch = ConditionWatch(actions.rules, catalog)
    runner = ActionRunner(actions, catalog, Hands(network=False), lambda _: None)
    for number in range(60):
        time = number / 4 + 70 * (number > 40)
        values = dict.fromkeys(watch.requires, float(number % 20))
        for fired in watch.add(time, values):
            assert fired.since <= fired.time
            for text in filter(None, (fired.rule.mark, fired.rule.speak)):
                assert runner.filled(text, fired)


def _check_error(error: CatalogError, data: bytes) -> None:
    assert 0 <= error.line <= data.count(b"\n") + 1
    assert error.problem.en
    assert error.problem.ru
