"""Topics and identifiers: valid for any name, and never two names with one."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.errors import UsageError
from mikas.publish.topics import Topics, check_topic, identifier

ODD = st.text(st.sampled_from("aB0_-+#/%$ :.é\0\n\ud800Ж"), max_size=8)


@given(ODD, ODD)
def test_a_channel_has_one_valid_topic_of_its_own(one, two):
    """A user's mnemonic may have any characters: wildcards and levels are none in its topic."""
    try:
        topics = [Topics("garage/volga").value(name) for name in (one, two)]
    except UnicodeEncodeError:
        assert "\ud800" in one + two  # half a character; a catalog has none
        return
    for topic in topics:
        assert re.fullmatch(r"garage/volga/value/[^+#/\0]*", topic)
        assert topic.isascii()
    assert (topics[0] == topics[1]) is (one == two)


@given(st.text(max_size=12), st.text(max_size=12))
def test_an_identifier_is_plain_and_of_one_text(one, two):
    if "\ud800" <= max(one + two, default="") <= "\udfff":
        return
    first, second = identifier(one), identifier(two)
    assert re.fullmatch("[A-Za-z0-9_-]*", first)
    assert (first == second) is (one == two)


def test_identifiers_can_be_read():
    assert Topics("mikas/car").identifier == "mikas--car"
    assert identifier("FUEL_FLOW") == "FUEL_FLOW"
    assert identifier("0x3F:2") == "0x3F-3A2"


@pytest.mark.parametrize(
    "topic",
    [
        "",
        "/a",
        "a/",
        "a//b",
        "a/+",
        "#",
        "a/#/b",
        "$SYS/a",
        "a\0b",
        "a\nb",
        "a\u202eb",
        "я" * 101,
        "a\ufdd0",
        "a\U0001ffff",
    ],
)
def test_a_topic_that_no_broker_takes_is_refused(topic):
    with pytest.raises(UsageError) as caught:
        check_topic(topic)
    assert caught.value.text.ru != caught.value.text.en


@pytest.mark.parametrize("topic", ["car", "mikas/car", "гараж/Волга 3110", "a/$b"])
def test_other_topics_are_taken(topic):
    assert Topics(topic).values == f"{topic}/values"
