"""Reading and writing `actions.toml`: every mistake with its file and line."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.catalog import shipped
from mikas.conditions import RecordAction, actions_toml, load_actions, read_actions
from mikas.errors import CatalogError
from mikas.i18n import Text

CATALOG = shipped()
WHOLE = """\
[mqtt]
broker = "mqtt://192.168.1.10"
topic = "garage/actions"

[action.hot]
when = "TWAT > 105 and FREQ > 500"
for = 3
until = "TWAT < 100"
again = 60
once = true
mark = "hot: {TWAT}"
record = "start"
sound = true
speak = { en = "Too hot, {TWAT}", ru = "Перегрев, {TWAT}" }
mqtt = true
webhook = "http://localhost:1880/hot"

[action.calm]
when = "обороты < 700"
record = "stop"
"""


def test_a_whole_file():
    actions = read_actions("a.toml", WHOLE, CATALOG)
    assert (actions.broker, actions.topic) == ("mqtt://192.168.1.10", "garage/actions")
    hot, calm = actions.rules
    assert (hot.name, hot.hold, hot.again, hot.once) == ("hot", 3, 60, True)
    assert hot.mark == Text("hot: {TWAT}", "hot: {TWAT}")
    assert hot.speak == Text("Too hot, {TWAT}", "Перегрев, {TWAT}")
    assert hot.channels == ("TWAT", "FREQ")
    assert (hot.record, calm.record) == (RecordAction.START, RecordAction.STOP)
    assert calm.channels == ("FREQ",)


@pytest.mark.parametrize(
    ("text", "line", "says"),
    [
        ('[action.a]\nwhen = "TWAT >"\nsound = true', 2, "not a formula"),
        ('[action.a]\nwhen = "TWOT > 1"\nsound = true', 2, "nearest is TWAT"),
        ('[action.a]\nwhen = "5 > 1"\nsound = true', 2, "names no parameter"),
        ('[action.a]\nwhen = "FUEL_USED > 1"\nsound = true', 2, "a total"),
        ('[action.a]\nwhen = "TWAT > 1"\nuntil = "TWAT <"\nsound = true', 3, "not a formula"),
        ('[action.a]\nwhen = "TWAT > 1"', 1, "does nothing"),
        ("[action.a]\nsound = true", 1, "has no `when`"),
        ('[action.a]\nwhen = "TWAT > 1"\nsound = "yes"', 3, "true or false"),
        ('[action.a]\nwhen = "TWAT > 1"\nfor = -1\nsound = true', 3, "from 0 to 3600"),
        ('[action.a]\nwhen = "TWAT > 1"\nrecord = "pause"', 3, "one of"),
        ('[action.a]\nwhen = "TWAT > 1"\nmark = "{FREQ}"', 3, "not in `when`; there are: {TWAT}"),
        ('[action.a]\nwhen = "TWAT > 1"\nmark = "{TWAT!r}"', 3, "write {TWAT}"),
        ('[action.a]\nwhen = "TWAT > 1"\nmark = "{TWAT:.1f}"', 3, "write {TWAT}"),
        ('[action.a]\nwhen = "TWAT > 1"\nspeak = "{}"', 3, "write {TWAT}"),
        ('[action.a]\nwhen = "TWAT > 1"\nmark = "{"', 3, "single brace"),
        (f'[action.a]\nwhen = "TWAT > 1"\nmark = "{"x" * 201}"', 3, "longer than 200"),
        ('[action.a]\nwhen = "TWAT > 1"\nmqtt = true', 3, "broker"),
        ('[action.a]\nwhen = "TWAT > 1"\nwrite = "UOZ"', 3, "unknown key `write`"),
        ('[action."a b"]\nwhen = "TWAT > 1"\nsound = true', 1, "name"),
        ('[action.a]\nwhen = "TWAT > 1"\nwebhook = "http://10.0.0.1/"', 3, "not this computer"),
        ('[rule.a]\nwhen = "TWAT > 1"', 1, "unknown key `rule`"),
        ("action = 5", 1, "table"),
        ("x", 1, "not TOML"),
    ],
)
def test_a_mistake_has_its_line(tmp_path, text, line, says):
    file = tmp_path / "actions.toml"
    file.write_text(text, "utf-8")
    with pytest.raises(CatalogError, match=says) as caught:
        load_actions(file, CATALOG)
    assert caught.value.file == str(file)
    assert caught.value.line == line
    assert caught.value.text.ru != caught.value.text.en


def test_a_file_that_is_missing_says_so(tmp_path):
    with pytest.raises(CatalogError, match="can't be read"):
        load_actions(tmp_path / "none.toml", CATALOG)


def test_a_file_has_fifty_rules_at_most():
    text = "".join(f'[action.r{n}]\nwhen = "TWAT > 1"\nsound = true\n' for n in range(51))
    with pytest.raises(CatalogError, match="more than 50"):
        read_actions("a.toml", text, CATALOG)


WORDS = st.text(
    st.characters(exclude_categories=("Cs", "Cc"), exclude_characters="{}"), max_size=20
)


@given(
    st.lists(
        st.fixed_dictionaries(
            {
                "name": st.from_regex(r"[\w-]{1,40}", fullmatch=True),
                "hold": st.sampled_from([0, 0.5, 3, 3600]),
                "again": st.sampled_from([0, 0.25, 60]),
                "once": st.booleans(),
                "sound": st.booleans(),
                "record": st.sampled_from(["start", "stop"]),
                "en": WORDS,
                "ru": WORDS,
                "until": st.sampled_from(["", "TWAT < 5"]),
            }
        ),
        max_size=5,
        unique_by=lambda it: it["name"],
    ),
    st.sampled_from(["", "mqtt://host"]),
)
def test_what_is_written_is_read_back(rules, broker):
    import json

    lines = [f"[mqtt]\nbroker = {json.dumps(broker)}"] if broker else []
    for it in rules:
        lines += [
            f"[action.{json.dumps(it['name'], ensure_ascii=False)}]",
            'when = "TWAT > 1"',
            f"for = {it['hold']}",
            f"again = {it['again']}",
            f"once = {json.dumps(it['once'])}",
            f"sound = {json.dumps(it['sound'])}",
            f"record = {json.dumps(it['record'])}",
        ]
        if it["until"]:
            lines.append(f"until = {json.dumps(it['until'])}")
        if it["en"] or it["ru"]:
            en, ru = (json.dumps(it[key], ensure_ascii=False) for key in ("en", "ru"))
            lines.append(f"speak = {{ en = {en}, ru = {ru} }}")
    first = read_actions("a.toml", "\n".join(lines), CATALOG)
    assert read_actions("a.toml", actions_toml(first), CATALOG) == first


@given(st.text(max_size=200))
def test_no_text_breaks_the_reader(text):
    try:
        read_actions("a.toml", text, CATALOG)
    except CatalogError as error:
        assert error.file == "a.toml"
