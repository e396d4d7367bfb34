"""The unit's list in a later session: its names are kept, and give no value of another list."""

from __future__ import annotations

import os

import pytest
from client_harness import bench, ecu_on

from mikas.errors import ListLost, NoList, NotSupported, UsageError, WrongLength
from mikas.virtual.fault_injector import LineFault
from mikas.virtual.responder import Identity
from virtual_harness import DATA


@pytest.fixture
def lists(tmp_path):
    return tmp_path / "lists"


def set_by(it, lists, *names):
    with ecu_on(it, lists=lists) as ecu:
        return ecu.set_list(*names)


def read_by(it, lists, *names, **settings):
    with ecu_on(it, lists=lists, **settings) as ecu:
        return {name: r.raw for name, r in ecu.read_list(*names).items()}


@pytest.mark.parametrize("names", [("TWAT",), ("INJ",), ("TWAT", "RXX", "BITPOW", "0x3F:2")])
def test_a_later_session_reads_it(lists, names):
    it = bench()
    set_by(it, lists, *names)
    assert list(read_by(it, lists)) == list(names)
    assert it.requests(0x64) == []  # reading sets nothing
    assert it.requests(0x63) == [b"\x63"]
    assert read_by(it, lists, *names) == read_by(it, lists)


def test_nothing_is_kept_and_nothing_is_sent(lists):
    it = bench()
    with ecu_on(it, lists=lists) as ecu:
        with pytest.raises(NoList):
            ecu.read_list()
        assert it.requests() == []


@pytest.mark.parametrize("unknown", ["silent", "01"])
@pytest.mark.parametrize("again", [False, True])
def test_after_a_power_cycle_the_advice_is_to_set_it_again(lists, unknown, again):
    it = bench(unknown=unknown)
    set_by(it, lists, "TWAT", "FREQ")
    with ecu_on(it, lists=lists) as ecu:
        if again:
            ecu.read_list()
        it.power_cycle(ecu)
        with pytest.raises(ListLost, match="set the list again"):
            ecu.read_list()
    with pytest.raises(NoList):
        read_by(it, lists)


@pytest.mark.parametrize("lost", [b"", None])
def test_a_list_that_the_unit_lost_is_to_be_set_again(lists, lost):
    it = bench()
    set_by(it, lists, "TWAT", "FREQ")
    responder, answer = it.bus.ecu.responder, type(it.bus.ecu.responder).answer

    class Forgetful:
        def __getattr__(self, name):
            return getattr(responder, name)

        def answer(self, body, now):
            return lost if body == b"\x63" else answer(responder, body, now)

    it.bus.ecu.responder = Forgetful()
    with pytest.raises((ListLost, WrongLength), match=r"[Ss]et the list again"):
        read_by(it, lists)


def test_wrong_names_leave_the_kept_ones(lists):
    it = bench()
    set_by(it, lists, "TWAT", "FREQ")
    with pytest.raises(WrongLength, match="other parameters than those named"):
        read_by(it, lists, "TWAT", "FREQ", "INJ")
    assert list(read_by(it, lists)) == ["TWAT", "FREQ"]


def test_another_list_of_another_size_is_refused(lists):
    it = bench()
    set_by(it, lists, "TWAT", "FREQ")
    with ecu_on(it) as stranger:
        stranger.set_list("TWAT", "INJ")
    with pytest.raises(WrongLength, match="another list than the one expected"):
        read_by(it, lists)
    with pytest.raises(NoList):
        read_by(it, lists)
    assert read_by(it, lists, "TWAT", "INJ") == {"TWAT": DATA[0x1A], "INJ": DATA[0x3F]}


@pytest.mark.parametrize(
    "act",
    [
        lambda ecu: next(ecu.watch("THR", "UACC", method="list")),
        lambda ecu: ecu.raw(b"\x64\x20\x1e"),
        lambda ecu: ecu.forget_list(),
    ],
    ids=["watch", "raw", "forget"],
)
def test_every_other_64_drops_the_names(lists, act):
    """A list of the same size would be read as the old one."""
    it = bench()
    set_by(it, lists, "TWAT", "FREQ")
    with ecu_on(it, lists=lists) as ecu:
        act(ecu)
    with pytest.raises(NoList):
        read_by(it, lists)


def test_a_64_that_fails_leaves_no_names(lists):
    it = bench()
    set_by(it, lists, "TWAT", "FREQ")
    with ecu_on(it, lists=lists, retries=0) as ecu:
        it.next_faults(LineFault.DAMAGED)  # the unit has it; the answer is not certain
        with pytest.raises(Exception, match="damaged"):
            ecu.set_list("THR", "UACC")
    with pytest.raises(NoList):
        read_by(it, lists)


def test_another_unit_and_one_without_passports_have_none(lists):
    it = bench()
    set_by(it, lists, "TWAT")
    with pytest.raises(NoList):
        read_by(bench(identity=Identity(0x0A, ("another",) * 8)), lists)
    nameless = bench(identity=Identity(0x0A, ("",) * 8))
    set_by(nameless, lists, "TWAT")
    with pytest.raises(NoList):
        read_by(nameless, lists)
    assert read_by(nameless, lists, "TWAT") == {"TWAT": DATA[0x1A]}


DEEP = '{"names": ' + "[" * 9_999


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"names": 5}', '{"names": []}', DEEP])
def test_an_invalid_file_is_none(lists, text):
    it = bench()
    set_by(it, lists, "TWAT")
    (file,) = lists.iterdir()
    file.write_text(text, "utf-8")
    with pytest.raises(NoList):
        read_by(it, lists)


def test_a_unit_that_knows_64_but_not_63_is_said_to(lists):
    with ecu_on(bench(missing="63"), lists=lists) as ecu:
        ecu.set_list("TWAT")
        with pytest.raises(NotSupported, match="does not know CREADL") as caught:
            ecu.read_list()
        assert not isinstance(caught.value, ListLost)


@pytest.mark.parametrize("why", ["full", "no passport"])
def test_names_that_can_not_be_kept_are_said_and_the_list_is_set(lists, said, why):
    it = bench()
    if why == "full":
        lists.write_text("in the place of the folder")
    with ecu_on(it, lists=lists, retries=0) as ecu:
        if why == "no passport":
            answer = it.link.write

            def damage(data):
                if data and data[0] == 0x51:
                    it.next_faults(*[LineFault.DAMAGED] * 4)
                answer(data)

            it.link.write = damage
        ecu.set_list("TWAT", "FREQ")
        it.link.write = type(it.link).write.__get__(it.link)
        assert list(ecu.read_list()) == ["TWAT", "FREQ"]
        ecu.set_list("TWAT", "INJ")
    (sentence,) = said
    assert f"can't be saved in {lists} (" in sentence.en
    assert "не сохраняются" in sentence.ru


def test_names_that_cannot_be_dropped_stop_the_64(lists, monkeypatch):
    it = bench()
    set_by(it, lists, "TWAT")

    def full(self, missing_ok=False):
        raise PermissionError(13, "Permission denied")

    with ecu_on(it, lists=lists) as ecu:
        monkeypatch.setattr("pathlib.Path.unlink", full)
        with pytest.raises(UsageError, match="Permission denied"):
            ecu.set_list("THR")
        assert it.requests(0x64) == []


@pytest.mark.posix
def test_what_lies_in_the_folder_of_lists_stops_no_list(lists, tmp_path):
    it, secret = bench(), tmp_path / "secret"
    secret.write_text("not yours")
    set_by(it, lists, "TWAT")
    (kept,) = lists.glob("*.json")
    for text in (
        "[" * 200_000,
        "9" * 5000,
        '{"names": 5}',
        "[]",
        '{"names": ' + "1" * 70_000 + "}",
    ):
        kept.write_text(text)
        with pytest.raises(NoList):
            read_by(it, lists)
    kept.unlink()
    os.mkfifo(kept)
    (lists / "folder.json").mkdir()
    (lists / "link.json").symlink_to(secret)
    (lists / f"{kept.name}.new").symlink_to(secret)
    with pytest.raises(NoList):
        read_by(it, lists)
    set_by(it, lists, "TWAT")
    assert list(read_by(it, lists)) == ["TWAT"]
    assert secret.read_text() == "not yours"
