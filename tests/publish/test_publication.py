"""The messages of a session, on simulated time: no value that was not read just now."""

from __future__ import annotations

from itertools import pairwise
from math import inf

import pytest
from publication_harness import CATALOG, TOPICS, Published, content, drive, publication

from mikas.client import Passport, Reading
from mikas.errors import EchoOnly
from mikas.i18n import Text
from mikas.publish.outbox import MessageKind
from mikas.sampling.events import (
    AlarmChanged,
    CycleFailed,
    FaultReading,
    LineState,
    ParameterDropped,
    Sampled,
    StateChanged,
    UnitFound,
)

KEY_OFF = "&scenario=key-off&faults=13,53"
NAMES = ("FREQ", "TWAT", "RXX", "FUEL_FLOW")


def key_off(*names: str, seconds: float = 60, **options: object) -> Published:
    """The engine runs, and the ignition is off from 20 s to 35 s."""
    names = names or NAMES
    made = publication(*(name.partition("/")[0] for name in names), **options)
    return Published.of(drive(KEY_OFF, *names, seconds=seconds, rate=5.0), made)


@pytest.fixture(scope="module")
def outage() -> Published:
    return key_off()


def reading(name: str, value: float, time: float) -> Reading:
    parameter = CATALOG.parameter(name)
    return Reading(parameter, value, parameter.unit, b"\x00", time, "corrected")


def sample(time: float, **values: float) -> Sampled:
    return Sampled(time, {name: reading(name, value, time) for name, value in values.items()}, {})


def test_values_come_in_the_interval_and_are_the_latest(outage):
    times = [each["time"] for each in outage.under("values")]
    running = [time for time in times if time < 19]
    assert all(b - a == pytest.approx(1, abs=0.2) for a, b in pairwise(running[1:]))
    latest: dict[str, object] = {}
    for event, messages in outage.steps:
        if isinstance(event, Sampled):
            latest |= {name: it.value for name, it in {**event.fresh, **event.derived}.items()}
            for message in messages:
                if message.topic == TOPICS.values:
                    assert content(message)["values"] == {name: latest[name] for name in NAMES}
                    assert content(message)["gap"] is False


def test_no_value_is_ever_older_than_a_second(outage):
    """While the ignition is off, all of them are null, from the very message of the break on."""
    read: dict[str, float] = {}
    nulls = 0
    for event, messages in outage.steps:
        if isinstance(event, Sampled):
            read |= dict.fromkeys({**event.fresh, **event.derived}, event.time)
        for message in messages:
            if message.topic != TOPICS.values:
                continue
            values = content(message)["values"]
            for name, value in values.items():
                assert value is None or event.time - read[name] <= 1.0
            nulls += all(value is None for value in values.values())
            assert content(message)["gap"] is all(value is None for value in values.values())
    assert nulls >= 8  # one for each attempt
    times = [each["time"] for each in outage.under("values")]
    assert max(b - a for a, b in pairwise(times)) < 4


def test_the_break_is_said_at_once_with_its_reason(outage):
    at = [isinstance(event, StateChanged) and event.is_broken for event, _ in outage.steps]
    event, messages = outage.steps[at.index(True)]
    state, values = (
        next(content(it) for it in messages if it.topic == topic)
        for topic in (TOPICS.state, TOPICS.values)
    )
    assert (state["state"], state["code"]) == ("echo-only", "EchoOnly")
    assert state["time"] == values["time"] == pytest.approx(event.time)
    assert state["reason"] == values["reason"] == event.reason._asdict()
    assert set(values["values"].values()) == {None}


def test_the_state_is_that_of_the_line(outage):
    told = [each["state"] for each in outage.under("state")]
    assert told[:3] == ["ecu-alive", "sampling", "echo-only"]
    assert told[-1] == "sampling"
    assert all(each["text"]["ru"] for each in outage.under("state"))


def test_faults_are_current_only_while_the_unit_answers(outage):
    told = outage.under("faults")
    assert [each["code"] for each in told[0]["faults"]] == [13, 53]
    assert told[0]["faults"][0]["text"] == CATALOG.fault(13).text._asdict()
    assert told[0]["count"] == 2
    currents = [each["current"] for each in told]
    broken = currents.index(False)
    assert set(currents[:broken]) == {True}
    assert told[broken]["time"] == told[broken - 1]["time"]  # of the reading, not of the break
    assert currents[broken + 1] is True  # read again


def test_before_the_first_event_nothing_is_known():
    _, faults, alarms, state = map(content, publication("FREQ").begin())
    assert (faults["count"], faults["faults"], faults["current"]) == (None, None, False)
    assert alarms["current"] is False
    assert (state["state"], state["time"]) == ("starting", None)


def test_channels_have_the_unit_in_which_their_values_are():
    for interpretation, unit in (("corrected", "rpm"), ("literal", "1/s")):
        made = publication("FREQ", "RXX", "FUEL_FLOW", interpretation=interpretation)
        freq, rxx, flow = content(made.begin()[0])["channels"]
        assert (freq["name"], freq["unit"], freq["flag"]) == ("FREQ", unit, False)
        assert (rxx["unit"], rxx["flag"]) == ("", True)
        assert (flow["unit"], flow["text"]) == (
            "l/h", CATALOG.channel("FUEL_FLOW").text._asdict(),
        )  # fmt: skip


def test_after_the_end_the_state_is_stopped_and_no_sample_is_forgotten():
    made = publication("FREQ", samples=True)
    made.messages_of(sample(5.0, FREQ=800))
    made.messages_of(sample(5.5, FREQ=840))
    samples, state = made.last_messages(5.5)
    assert content(samples)["samples"] == [[5.5, 840]]
    assert (content(state)["state"], content(state)["time"]) == ("stopped", 5.5)


def test_events_are_those_that_a_person_would_note_each_once(outage):
    kinds = [each["kind"] for each in outage.under("event")]
    assert set(kinds) == {"state", "unit", "faults", "gap"}
    assert kinds.count("faults") == 1  # the readings after it were the same
    assert kinds.count("gap") == 2  # its begin and its end
    began, ended = (each for each in outage.under("event") if each["kind"] == "gap")
    assert (began["ended"], ended["began"]) == (None, began["began"])
    assert 15 < ended["ended"] - ended["began"] < 22


def test_every_message_is_json_with_its_schema_and_fits_its_kind(outage):
    kinds = {
        "values": MessageKind.LIVE,
        "event": MessageKind.EVENT,
        **dict.fromkeys(("state", "unit", "faults", "alarms"), MessageKind.RETAINED),
    }
    for message in outage.messages:
        name = message.topic.removeprefix(f"{TOPICS.base}/")
        assert message.kind is kinds[name]
        assert content(message)["schema"] == 1
        assert message.qos == (0 if name == "values" else 1)
        assert message.retain is (message.kind is MessageKind.RETAINED)


def test_every_sample_is_in_one_row_in_order():
    made = key_off("FREQ", "TWAT/10", samples=True, every=2.0)
    batches = made.under("samples")
    rows = [row for batch in batches for row in batch["samples"]]
    sampled = [event for event, _ in made.steps if isinstance(event, Sampled)][: len(rows)]
    for row, event in zip(rows, sampled, strict=True):
        values = [event.fresh.get(name) for name in ("FREQ", "TWAT")]
        assert row == [round(event.time, 6), *(it and it.value for it in values)]
    assert [batch["first"] for batch in batches] == [
        sum(len(each["samples"]) for each in batches[:at]) for at in range(len(batches))
    ]
    assert {batch["session"] for batch in batches} == {rows[0][0]}
    assert batches[0]["names"] == ["FREQ", "TWAT"]
    assert sum(it.rows for it in made.messages) == len(rows)


def test_a_batch_is_sent_before_it_grows_without_bounds():
    made = publication("FREQ", samples=True, every=1e6)
    rows = [
        it.rows for n in range(2500) for it in made.messages_of(sample(n / 10, FREQ=800)) if it.rows
    ]
    assert rows == [1, 1000, 1000]


def test_a_slow_channel_keeps_its_value_until_it_is_due_and_shows_its_age():
    made = Published.of(
        drive("", "FREQ", "TWAT/10", seconds=60, rate=2), publication("FREQ", "TWAT")
    )
    later = [each for each in made.under("values") if each["time"] > 12]
    assert all(each["values"]["TWAT"] is not None for each in later)
    assert max(each["ages"].get("TWAT", 0) for each in later) == pytest.approx(5, abs=1.1)
    assert not any("FREQ" in each["ages"] for each in later)


def test_each_value_has_a_topic_of_its_own_if_wanted():
    made = publication("FREQ", "RXX", "0x3F:2", each=True, qos=2)
    got = {
        it.topic: (it.payload, it.qos, it.kind) for it in made.messages_of(sample(1.0, FREQ=800))
    }
    assert got[f"{TOPICS.base}/value/FREQ"] == (b"800", 2, MessageKind.LIVE)
    assert got[f"{TOPICS.base}/value/RXX"] == (b"null", 2, MessageKind.LIVE)
    assert got[f"{TOPICS.base}/value/0x3F:2"] == (b"null", 2, MessageKind.LIVE)


def alarm(time: float, level: str, *, name: str = "TWAT") -> AlarmChanged:
    return AlarmChanged(time, name, level, "none", "high", 105.0, 100.0, Text("hot", "горячо"))


def test_alarms_are_the_present_ones_and_current_only_with_values():
    made = publication("TWAT")

    def alarms(event):
        return [content(it) for it in made.messages_of(event) if it.topic == TOPICS.alarms]

    (first,) = alarms(sample(1.0, TWAT=105))
    assert (first["current"], first["alarms"]) == (True, [])
    (hot,) = alarms(alarm(1.0, "warning"))
    assert [each["name"] for each in hot["alarms"]] == ["TWAT"]
    assert hot["alarms"][0]["text"]["ru"] == "горячо"
    (broken,) = alarms(StateChanged(2.0, LineState.ECHO_ONLY, EchoOnly()))
    assert (broken["current"], broken["count"]) == (False, 1)
    (back,) = alarms(sample(9.0, TWAT=104))
    assert (back["current"], back["count"]) == (True, 1)
    (over,) = alarms(alarm(10.0, "none"))
    assert over["alarms"] == []
    alarms(alarm(11.0, "danger"))
    (dropped,) = alarms(ParameterDropped(12.0, "TWAT"))  # nobody knows any more
    assert dropped["alarms"] == []


def test_another_unit_has_nothing_of_the_one_before():
    made = publication("TWAT")
    for event in (sample(1.0, TWAT=90), FaultReading(1.1, (13,)), alarm(1.2, "warning")):
        made.messages_of(event)
    got = {
        it.topic: content(it) for it in made.messages_of(UnitFound(2.0, 0x0A, None, another=True))
    }
    assert (got[TOPICS.faults]["faults"], got[TOPICS.faults]["current"]) == (None, False)
    assert got[TOPICS.alarms]["alarms"] == []
    assert got[TOPICS.unit]["version_code"] == "0A"
    values = [
        content(it)
        for it in made.messages_of(CycleFailed(3.0, EchoOnly()))
        if it.topic == TOPICS.values
    ]
    assert [each["values"] for each in values] == [{"TWAT": None}]


def test_a_new_fault_is_news_with_its_number():
    made = publication("FREQ")

    def news(event):
        return [content(it) for it in made.messages_of(event) if it.topic == TOPICS.event]

    assert [each["added"] for each in news(FaultReading(1.0, (13,)))] == [None]
    assert news(FaultReading(2.0, (13,))) == []
    assert [each["added"] for each in news(FaultReading(3.0, (13, 53)))] == [[53]]


def test_a_number_that_json_lacks_is_null():
    made = publication("FREQ")
    (values,) = [it for it in made.messages_of(sample(1.0, FREQ=inf)) if it.topic == TOPICS.values]
    assert content(values)["values"] == {"FREQ": None}


def test_a_hostile_passport_steers_no_terminal():
    """A message may end on one: `mosquitto_sub` prints it as it is."""
    made, evil = publication("FREQ"), "\x1b]52;c;QQ==\x07\x9b2J\u202e\ud800"
    passport = Passport((evil, None, None), (None,) * 5)
    for message in made.messages_of(UnitFound(1.0, 0x0A, passport)):
        assert message.payload.decode().isprintable()
        assert content(message)["passport"][0] == evil
