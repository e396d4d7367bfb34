"""Which commands the unit knows: every one that changes nothing, the list, and all strokes."""

from __future__ import annotations

from math import inf

import pytest
from client_harness import bench, ecu_on, lines
from hypothesis import given
from hypothesis import strategies as st

from mikas.errors import EcuRefused, LineError, MikasError, NoConnection, NoList
from mikas.virtual.fault_injector import LineFault
from virtual_harness import DATA

STROKES = (0x7F, 0x80, 0x81, 0x82, 0x83)
CHANGING = {0x12, 0x14, 0x16, 0x22, 0x24, 0x26, 0x32, 0x41, 0x62}
STANDING = DATA | {0x29: b"\0", 0x2C: b"\0"}


def tried(ecu) -> dict[int, tuple[bool | None, str]]:
    """What was found of each command, and the reason."""
    found = list(ecu.supported())
    assert [support.code for support in found if support.code not in (0x63, 0x64)] == sorted(
        support.code for support in found if support.code not in (0x63, 0x64)
    )
    return {it.code: (it.known, it.reason.en if it.reason else "") for it in found}


def test_a_whole_unit_supports_everything():
    it = bench()
    ecu = ecu_on(it)
    found = tried(ecu)
    assert found == {code: (None if code in CHANGING else True, "") for code in found}
    assert {0x63, 0x64, 0x71, *STROKES} <= found.keys()
    assert not CHANGING.intersection(body[0] for body in it.requests())
    assert it.requests(0x64) == [b"\x64\x29\x29"]  # a list that any tester can read
    assert it.requests(0x63) == [b"\x63"]
    names = [support.name for support in ecu.supported()]
    assert "CREADPS (7F)" in names
    assert "CREADPS (83)" in names
    titles = {support.code: support.title for support in ecu.supported()}
    assert (titles[0x7F].en, titles[0x83].ru) == (
        "stream at a stroke (0)",
        "поток по такту двигателя (4)",
    )


@pytest.mark.parametrize("stream_end", ["byte", "request", "break"])
def test_every_stream_is_ended(stream_end):
    """D12."""
    it = bench(stream_end=stream_end)
    ecu = ecu_on(it)
    for support in ecu.supported():
        assert it.bus.ecu.next_transmission() == inf, support
        assert support.known is not False
    assert ecu.read("TWAT")["TWAT"].raw == DATA[0x1A]


def test_with_the_engine_standing_no_stroke_is_tried():
    """D15."""
    it = bench(STANDING, rpm=0)
    found = tried(ecu_on(it))
    assert {found[code] for code in STROKES} == {(None, "the engine is not turning")}
    assert found[0x71] == (True, "")
    assert not {body[0] for body in it.requests()} & {*STROKES}


def test_strokes_are_undecided_if_the_engine_stops_meanwhile():
    it = bench(rpm=0)  # FREQ says 850: it stopped after that
    ecu = ecu_on(it)
    responder = it.bus.ecu.responder
    answer = responder.answer

    class Stopping:
        def __getattr__(self, name):
            return getattr(responder, name)

        def answer(self, body, now):
            if body[0] in STROKES:
                it.car.data[0x29] = b"\0"
            return answer(body, now)

    it.bus.ecu.responder = Stopping()
    found = tried(ecu)
    assert {found[code] for code in STROKES} == {(None, "the engine is not turning")}
    assert len([body for body in it.requests() if body[0] in STROKES]) == 1


@pytest.mark.parametrize("rpm", [850, 0])
def test_without_a_speed_strokes_are_decided_by_what_comes(rpm):
    data = {code: raw for code, raw in DATA.items() if code not in (0x29, 0x2C)}
    found = tried(ecu_on(bench(data, rpm=rpm)))
    for code in STROKES:
        known, reason = found[code]
        assert known is (True if rpm else None)
        assert ("does not report" in reason) is (rpm == 0)


@pytest.mark.parametrize("unknown", ["silent", "01"])
class TestAUnitThatLacks:
    @pytest.mark.parametrize(
        ("missing", "lacking"), [("stroke", STROKES), ("7F,82", (0x7F, 0x82)), ("83", (0x83,))]
    )
    def test_strokes_that_the_unit_lacks_are_found(self, unknown, missing, lacking):
        ecu = ecu_on(bench(missing=missing, unknown=unknown))
        found = tried(ecu)
        assert {code: found[code] for code in STROKES} == {
            code: (code not in lacking, "") for code in STROKES
        }
        assert ecu.read("TWAT")

    def test_lists_that_the_unit_lacks_are_found(self, unknown):
        for missing in ("list", "64"):
            found = tried(ecu_on(bench(missing=missing, unknown=unknown)))
            assert found[0x64] == (False, "")
            assert found[0x63] == (None, "no list could be set (64)")
        found = tried(ecu_on(bench(missing="63", unknown=unknown)))
        assert (found[0x64], found[0x63]) == ((True, ""), (False, ""))

    @pytest.mark.parametrize("bad_write", ["silent", "01"])
    def test_a_list_of_one_code_counts_as_supported(self, unknown, bad_write):
        found = tried(ecu_on(bench(max_list=1, unknown=unknown, bad_write=bad_write)))
        assert (found[0x64], found[0x63]) == ((True, ""), (True, ""))
        quirks = {"max_list": 1, "unknown": unknown, "bad_write": bad_write}
        assert tried(ecu_on(bench(missing="63", **quirks)))[0x63] == (False, "")


def test_the_list_that_mikas_has_set_is_set_again(tmp_path):
    it = bench()
    ecu = ecu_on(it, lists=tmp_path)
    ecu.set_list("TWAT", "INJ")
    for _ in range(2):  # in the session that has set it, and in a later one
        it.forget()
        found = tried(ecu)
        assert (found[0x64], found[0x63]) == ((True, ""), (True, ""))
        assert it.requests(0x64) == [b"\x64\x1a\x3f"]
        assert list(ecu.read_list()) == ["TWAT", "INJ"]
        ecu = ecu_on(it, lists=tmp_path)
    assert list(ecu.read_list()) == ["TWAT", "INJ"]


def test_a_list_that_is_not_known_gives_no_wrong_value():
    ecu = ecu_on(bench())
    list(ecu.supported())
    with pytest.raises(NoList):
        ecu.read_list()


def test_the_list_passes_the_gate(tmp_path):
    it = bench()
    assert tried(ecu_on(it, journal=tmp_path / "j"))[0x64] == (True, "")
    assert [(e["state"], e["command"]) for e in lines(tmp_path / "j")] == [
        ("started", "CWRITL"), ("done", "CWRITL"),
    ]  # fmt: skip
    (tmp_path / "file").write_text("")
    for settings, word in (
        ({"confirm": lambda _: False}, "Not confirmed"),
        ({"journal": tmp_path / "file" / "j"}, "journal"),
    ):
        it.forget()
        found = tried(ecu_on(it, **settings))
        assert found[0x64][0] is None
        assert word in found[0x64][1]
        assert found[0x63] == (None, "no list could be set (64)")
        assert found[0x83] == (True, "")
        assert it.requests(0x64) == []


@given(st.lists(st.sampled_from([None, None, *LineFault]), max_size=40), st.booleans())
def test_whatever_happens_on_the_line_it_is_left_usable(line_faults, turning):
    it = bench(DATA if turning else STANDING, rpm=850 if turning else 0)
    ecu = ecu_on(it)
    it.next_faults(*line_faults)
    try:
        found = tried(ecu)
        assert not any(found[code][0] for code in CHANGING)
        assert turning or not any(found[code][0] for code in STROKES)
    except NoConnection:
        pass
    it.bus.fault_injector.queued.clear()
    for last in (False, True):
        try:
            assert ecu.read("TWAT")["TWAT"].raw == DATA[0x1A]
            break
        except (LineError, EcuRefused, NoConnection) as error:
            assert not last, error
    assert it.bus.ecu.next_transmission() == inf


def test_an_unplugged_adapter_ends_the_trials():
    it = bench()
    trials = ecu_on(it).supported()
    next(trials)
    it.link.unplug()
    with pytest.raises(MikasError, match="gone"):
        list(trials)
