"""Notices beside the values: each once, and only those that call for an action."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from mikas.cli.language import set_language
from mikas.cli.options.sampling import SamplingOptions
from mikas.cli.render.notices import Notices
from mikas.errors import (
    AnotherAdapter,
    DamagedResponse,
    EchoOnly,
    EngineStopped,
    LinkLost,
    NotSupported,
)
from mikas.i18n import Text
from mikas.sampling.events import AdapterMoved, CycleFailed, LineState, Sampled, StateChanged
from mikas.sampling.session import SamplingSession

CUT = DamagedResponse(damage=Text("cut", "обрыв"))
SILENT = EchoOnly()


@pytest.fixture(autouse=True)
def in_english():
    yield
    set_language("en")


def lines_of(*events, **asked) -> list[str]:
    session = SimpleNamespace(
        options=SamplingOptions(**asked),
        connected=True,
        recorder=SimpleNamespace(failure=None, on_file=None),
    )
    sentences: list[str] = []
    notices = Notices(session, sentences.append)
    followed = SamplingSession()
    for event in events:
        for each in followed.events_of(event):
            notices.show_event(each)
    return sentences


def well(time: float) -> StateChanged:
    return StateChanged(time, LineState.SAMPLING)


def sample(time: float) -> Sampled:
    return Sampled(time, {}, {})


def test_a_lost_cycle_is_no_news():
    assert (
        lines_of(
            well(0), sample(1), CycleFailed(1.5, CUT), sample(2), CycleFailed(2.5, CUT), sample(3)
        )
        == []
    )


def test_many_gaps_in_a_row_are_reported_once_and_their_end_once():
    gaps = [CycleFailed(1 + n / 2, CUT) for n in range(1, 12)]
    first, back = lines_of(well(0), sample(1), *gaps, sample(7))
    assert first.startswith("The response is damaged: cut. Check ground and plug")
    assert first.endswith(" Waiting; sampling resumes by itself.")
    assert back == "Back after 6 s."


def test_many_gaps_from_the_beginning_are_reported_once():
    (only,) = lines_of(
        well(5),
        CycleFailed(6, CUT),
        CycleFailed(7.9, CUT),
        CycleFailed(8, CUT),
        CycleFailed(9, CUT),
    )
    assert only.startswith("The response is damaged")


def test_a_standing_engine_is_reported_at_once_with_advice():
    set_language("ru")
    (only,) = lines_of(
        well(0), CycleFailed(2, EngineStopped(seconds=2)), CycleFailed(5, EngineStopped(seconds=2))
    )
    assert only == (
        "Тактов нет 2 с: двигатель не вращается. Поток по тактам идёт, только пока двигатель "
        "вращается: запустите его или возьмите другой способ. Ждём; опрос продолжится сам."
    )


def test_an_error_that_the_state_reports_is_not_reported_twice():
    off = StateChanged(6, LineState.ECHO_ONLY, SILENT)
    message = lines_of(
        well(0),
        sample(1),
        CycleFailed(6, SILENT),
        off,
        CycleFailed(7, SILENT),
        CycleFailed(8, SILENT),
    )
    assert [sentence.split(":")[0] for sentence in message] == ["Echo, but the ECU is silent"]


def test_ignition_on_again_without_an_engine_is_reported_as_such():
    off = StateChanged(3, LineState.ECHO_ONLY, SILENT)
    stands = CycleFailed(12, EngineStopped(seconds=2))
    message = lines_of(well(0), sample(1), off, well(10), stands, off, well(20), stands, sample(31))
    assert [" ".join(sentence.split()[:3]) for sentence in message] == [
        "Echo, but the", "No stroke for", "Echo, but the", "No stroke for", "Back after 30",
    ]  # fmt: skip


def test_no_advice_leaves_no_hole():
    refused = NotSupported(command=Text("it", "это"), advice=Text("", ""))
    refused.advice = Text("", "")
    (only,) = lines_of(well(0), sample(1), CycleFailed(9, refused))
    assert "  " not in only
    assert only.endswith(". Waiting; sampling resumes by itself.")


@pytest.mark.parametrize(
    ("language", "stranger", "moved"),
    [
        ("en", "another adapter has its port", "The adapter is now at /dev/ttyUSB1."),
        ("ru", "его порт занял другой", "Адаптер теперь на /dev/ttyUSB1."),
    ],
)
def test_a_stranger_on_the_port_and_a_new_name_are_reported(language, stranger, moved):
    set_language(language)
    problem = Text("another adapter has its port", "его порт занял другой")
    lost, other = LinkLost(url="x", problem=""), AnotherAdapter(url="x", problem=problem)
    first, second, third, _ = lines_of(
        well(0),
        sample(1),
        StateChanged(2, LineState.NO_PORT, lost),
        StateChanged(3, LineState.NO_PORT, other),
        AdapterMoved(9, "/dev/ttyUSB1", "/dev/ttyUSB0"),
        well(10),
        sample(11),
    )
    assert stranger not in first
    assert stranger in second
    assert third == moved
