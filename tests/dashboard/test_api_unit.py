"""Faults, passport, memory; changes in two steps; the journal of changes."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from dashboard.rig import ME, OTHER, rig
from mikas.commands import WriteList
from mikas.dashboard.security.control import LIFETIME
from protocol_codes import CODE_OF, SIMULATED


@pytest.fixture
def faulty(tmp_path):
    with rig(tmp_path, "sim:?scenario=warm-idle&faults=13,14") as it:
        it.sampling()
        yield it


def change(it, status=200, headers=ME, **wish):
    return it.post("/changes", wish, status, headers)


def confirm(it, asked, status=200, headers=ME):
    return it.post(f"/changes/{asked['nonce']}", status=status, headers=headers)


def test_faults_are_read_with_words_and_what_to_check(faulty):
    reported = faulty.get("/faults")
    assert [fault["code"] for fault in reported["faults"]] == [13, 14]
    assert reported["faults"][0]["text"]["ru"]
    assert reported["faults"][0]["related"] == ["JAIR"]
    assert reported["faults"][0]["first_seen"] <= reported["time"]
    assert faulty.get("/state")["fault_count"] == 2


def test_the_last_reading_of_the_faults_outlives_the_adapter(faulty):
    read = faulty.get("/faults")
    faulty.cars.pull()
    with faulty.live() as live:
        state = live.until(lambda m: m["state"]["line"] == "no-port")["state"]
    assert faulty.get("/faults", 503)["code"] == "NotConnected"
    assert faulty.get("/faults", last=True) == read
    assert (state["fault_count"], state["fault_time"]) == (2, read["time"])
    faulty.post("/disconnect")
    assert faulty.get("/faults", 503, last=True)["code"] == "NotConnected"


def test_faults_are_erased_in_two_steps_and_stand_in_the_journal(faulty):
    asked = change(faulty, kind="erase_faults")
    assert (asked["before"], asked["after"]) == ([13, 14], [])
    assert [lost["code"] for lost in asked["lost"]] == [13, 14]
    assert faulty.get("/faults")["count"] == 2
    assert confirm(faulty, asked) == {"before": [13, 14], "after": [], "done": True}
    assert faulty.get("/faults")["count"] == 0
    entries = faulty.get("/journal")["entries"]
    done = [entry for entry in entries if entry["before"] == "0D 0E"]
    assert [entry["state"] for entry in done] == ["done", "started"]
    assert done[0]["change"] == {
        "en": "erase 2 stored faults",
        "ru": "сбросить 2 ошибки",
    }


def test_an_erase_with_the_engine_running_is_asked_about(faulty):
    asked = change(faulty, kind="erase_faults")
    assert asked["danger"]
    assert asked["meaning"]["en"].startswith("The engine is running (8")
    assert asked["meaning"]["ru"].startswith("Двигатель работает (8")


def test_an_erase_that_was_asked_about_before_the_engine_started_is_asked_about_again(faulty):
    car = faulty.cars.car(faulty.dashboard.connection.port.url)
    running = car.raw
    car.raw = lambda code, now: b"\0" if code == CODE_OF["FREQ"] else running(code, now)
    asked = change(faulty, kind="erase_faults")
    assert (asked["danger"], asked["meaning"]) == (False, None)
    car.raw = running
    error = confirm(faulty, asked, 409)
    assert error["code"] == "ConfirmationOutdated"
    assert "engine" in str(error)
    assert faulty.get("/faults")["count"] == 2
    assert confirm(faulty, change(faulty, kind="erase_faults"))["after"] == []


def test_the_units_list_is_no_change_of_the_car(tmp_path):
    with rig(tmp_path, None) as it:
        entries = [
            {"time": 1, "change": "the list", "command": WriteList.SOURCE_NAME},
            {"time": 2, "change": "erase 1 stored fault", "command": "parameter write"},
        ]
        it.dashboard.settings.journal.parent.mkdir(parents=True, exist_ok=True)
        text = "".join(json.dumps(entry) + "\n" for entry in entries)
        it.dashboard.settings.journal.write_text(text, "utf-8")
        assert [entry["time"] for entry in it.get("/journal")["entries"]] == [2]


def test_older_entries_of_the_journal_are_in_english(tmp_path):
    with rig(tmp_path, None) as it:
        it.dashboard.settings.journal.parent.mkdir(parents=True)
        it.dashboard.settings.journal.write_text('{"time": 1.0, "change": "jump to 1234"}\n{}\n5\n')
        change = {"en": "jump to 1234", "ru": "jump to 1234"}
        assert it.get("/journal")["entries"] == [{"time": 1.0, "change": change}]


def test_a_line_of_the_journal_that_no_page_could_show_is_left_out(tmp_path):
    bad = ["[" * 9_999, '{"change": "x"}', '{"time": 1e999, "change": "x"}', '{"time": 1e12}']
    bad += ['{"time": 1, "change": [1]}', '{"time": 1, "before": {}}', f'{{"time": 1{"0" * 5000}}}']
    good = json.dumps({"time": 1.0, "change": "a\ud800\x1bb", "port": "\u202e"})
    with rig(tmp_path, None) as it:
        it.dashboard.settings.journal.parent.mkdir(parents=True)
        it.dashboard.settings.journal.write_text("\n".join([*bad, good]) + "\n")
        [entry] = it.get("/journal")["entries"]
        assert entry["change"]["en"] == "a\ufffd\ufffdb"
        assert entry["port"] == "\ufffd"


def test_a_nonce_is_good_once_for_one_client_for_two_minutes(faulty):
    asked = change(faulty, kind="erase_faults")
    faulty.post("/control/release")
    assert confirm(faulty, asked, 410, OTHER)["code"] == "ConfirmationExpired"
    faulty.post("/control/release", headers=OTHER)
    confirm(faulty, asked)
    assert confirm(faulty, asked, 410)["code"] == "ConfirmationExpired"
    assert faulty.post("/changes/made-up", status=410)["code"] == "ConfirmationExpired"
    late = change(faulty, kind="erase_faults")
    clock = faulty.dashboard.confirmations.clock
    faulty.dashboard.confirmations.clock = lambda: clock() + LIFETIME
    assert confirm(faulty, late, 410)["code"] == "ConfirmationExpired"


def test_what_is_no_longer_as_shown_is_not_changed(faulty):
    asked = change(faulty, kind="erase_faults")
    faulty.cars.car(faulty.dashboard.connection.port.url).faults.append(15)
    error = confirm(faulty, asked, 409)
    assert error["code"] == "ConfirmationOutdated"
    assert [fault["code"] for fault in faulty.get("/faults")["faults"]] == [13, 14, 15]


def test_a_change_shown_for_one_connection_is_nothing_to_the_next(faulty):
    asked = change(faulty, kind="erase_faults")
    faulty.post("/connect", {"port": "sim:?faults=13,14", "method": "batch", "rate": 5})
    faulty.sampling()
    assert confirm(faulty, asked, 410)["code"] == "ConfirmationExpired"


def test_the_passport_is_read_once_and_for_all(idle):
    reported = idle.get("/passport")
    assert reported["model"]["ru"] == "Микас 7.1"
    assert reported["parameter_count"] == SIMULATED
    assert (reported["echo"], reported["baud"]) == (True, 9600)
    assert reported["supported"] is None
    idle.post("/relearn")
    assert idle.get("/passport", headers=OTHER)["version_code"] == reported["version_code"]


@pytest.mark.parametrize(("pause", "kept"), [(None, 0.1), (0.2, 0.2)])
def test_the_pause_before_a_request_is_found_or_set(off, pause, kept):
    """D14."""
    off.post("/connect", {"port": "sim:?least_pause=0.1", "pause": pause})
    off.sampling()
    assert off.get("/passport")["pause"] == kept


def test_the_state_says_which_pause_is_kept_and_whether_it_was_chosen(off):
    """Auto finds it again, also where the program was started with one (D14)."""
    assert off.get("/state")["pause"] is None
    kept = []
    off.dashboard.settings = replace(
        off.dashboard.settings, connection=replace(off.dashboard.settings.connection, pause=0.15)
    )
    for pause in (None, 0.2, "auto"):
        off.post("/connect", {"port": "sim:?least_pause=0.1", "pause": pause})
        kept.append(off.sampling()["pause"])
    assert kept == [
        {"chosen": 0.15, "seconds": 0.15},
        {"chosen": 0.2, "seconds": 0.2},
        {"chosen": None, "seconds": 0.1},
    ]


def test_a_chosen_pause_is_that_of_the_check_too(off):
    off.post("/connect", {"port": "sim:?scenario=warm-idle", "pause": 0.07})
    off.sampling()
    lines = off.client.post("/api/doctor", json={}, headers=ME).text.splitlines()
    steps = {step["name"]: step for step in map(json.loads, lines)}
    assert "70 ms" in steps["line"]["detail"]["en"]
    assert off.sampling()["pause"]["chosen"] == 0.07


@pytest.mark.parametrize("pause", [-1, 2.5, "soon"])
def test_what_is_no_pause_is_refused(off, pause):
    off.post("/connect", {"port": "sim:", "pause": pause}, 400)


def test_who_disconnects_meanwhile_spoils_no_answer(faulty):
    ask = faulty.dashboard.connection.ask

    async def ask_and_lose(job, **more):
        answer = await ask(job, **more)
        faulty.dashboard._clear_unit()  # noqa: SLF001
        return answer

    faulty.dashboard.connection.ask = ask_and_lose
    assert faulty.get("/faults")["count"] == 2
    assert change(faulty, kind="erase_faults")["before"] == [13, 14]
    assert faulty.get("/passport")["version_code"] == "0A"
    assert faulty.post("/passport/probe")["supported"]
    assert faulty.dashboard.info is None


def test_every_command_is_tried_on_request(shared_idle):
    reported = shared_idle.post("/passport/probe")["supported"]
    known = {it["source_name"]: it["supported"] for it in reported}
    assert known["CREADP"] is True
    assert None in known.values()  # what would change something is not tried
    assert shared_idle.get("/passport")["supported"] == reported


def test_memory_is_read_in_every_space(shared_idle):
    for space in ("ram", "xram", "code", "sfr"):
        reported = shared_idle.get(f"/memory/{space}", address="0x80", count=8)
        assert (reported["address"], len(reported["data"])) == (0x80, 16)
    whole = shared_idle.get("/memory/code", address="4096", count=256)["data"]
    part = shared_idle.get("/memory/code", address="0x1010", count=4)["data"]
    assert whole[32:40] == part


@pytest.mark.parametrize(
    ("space", "address", "count"),
    [("ram", "0xF0", 17), ("code", "65536", 1), ("rom", "0", 1), ("ram", "-1", 1),
     ("ram", "0", 0), ("xram", "0", 1025), ("ram", "0x", 1)],
)  # fmt: skip
def test_addresses_outside_are_refused(shared_idle, space, address, count):
    assert shared_idle.get(f"/memory/{space}", 400, address=address, count=count)["ru"]


def test_writing_is_locked_until_somebody_unlocks_it(idle):
    wish = {"kind": "write_memory", "space": "xram", "address": 0x100, "data": "AB"}
    assert change(idle, 403, **wish)["code"] == "Locked"
    assert change(idle, 403, kind="write_parameter", name="UOZ", value=10)["code"] == "Locked"
    assert idle.post("/unlock", {"minutes": 5})["unlocked_until"] > idle.get("/state")["now"]
    asked = change(idle, **wish)
    idle.post("/lock")
    assert confirm(idle, asked, 403)["code"] == "Locked"
    idle.post("/unlock", {"minutes": 5})
    clock = idle.dashboard.clock
    idle.dashboard.write_lock.clock = lambda: clock() + 301
    assert change(idle, 403, **wish)["code"] == "Locked"
    assert idle.get("/state")["unlocked_until"] is None


def test_a_cell_is_written_and_read_back(shared_idle):
    before = shared_idle.get("/memory/xram", address="0x100", count=2)["data"]
    shared_idle.post("/unlock", {})
    asked = change(shared_idle, kind="write_memory", space="xram", address=0x100, data="ABCD")
    assert (asked["before"], asked["after"], asked["danger"]) == (before, "ABCD", False)
    assert asked["meaning"]["ru"]
    done = confirm(shared_idle, asked)
    assert (done["before"], done["after"]) == (before, "ABCD")
    assert shared_idle.get("/memory/xram", address="0x100", count=2)["data"] == "ABCD"


def test_the_program_is_dangerous_and_says_so(shared_idle):
    shared_idle.post("/unlock", {})
    asked = change(shared_idle, kind="write_memory", space="code", address=0x100, data="00")
    assert asked["danger"] is True
    assert "engine" in asked["meaning"]["en"]


def test_a_cell_that_moved_meanwhile_is_left_alone(shared_idle):
    shared_idle.post("/unlock", {})
    wish = {"kind": "write_memory", "space": "xram", "address": 0x200}
    asked = change(shared_idle, **wish, data="11")
    confirm(shared_idle, change(shared_idle, **wish, data="22"))
    assert confirm(shared_idle, asked, 409)["code"] == "ConfirmationOutdated"
    assert shared_idle.get("/memory/xram", address="0x200", count=1)["data"] == "22"


def test_a_parameter_is_written_by_its_value(shared_idle):
    shared_idle.post("/unlock", {})
    asked = change(shared_idle, kind="write_parameter", name="RCOD", value=-0.5)
    assert asked["after"]["raw"]
    assert "→" in asked["meaning"]["ru"]
    assert "без питания, неизвестно" in asked["meaning"]["ru"]
    done = confirm(shared_idle, asked)
    assert done["after"]["raw"] == asked["after"]["raw"]


@pytest.mark.parametrize(
    "wish",
    [
        {"kind": "write_parameter", "name": "UOZ"},
        {"kind": "write_parameter", "name": "UOZ", "value": 1, "raw": "00"},
        {"kind": "write_parameter", "name": "UOZ", "value": 9999},
        {"kind": "write_parameter", "name": "UOZ", "raw": "0000"},
        {"kind": "write_parameter", "name": "DET", "value": 1},
        {"kind": "write_parameter", "name": "NOPE", "value": 1},
        {"kind": "write_memory", "space": "ram", "address": 0xFF, "data": "0000"},
        {"kind": "write_memory", "space": "ram", "address": 0, "data": "0"},
        {"kind": "goto", "address": 0},
        {},
    ],
)
def test_a_change_that_makes_no_sense_is_refused(shared_idle, wish):
    shared_idle.post("/unlock", {})
    assert change(shared_idle, 400, **wish)["en"]


def test_an_outcome_is_not_journalled_where_there_is_no_journal(faulty):
    asked = change(faulty, kind="erase_faults")
    faulty.dashboard.settings.journal.unlink(missing_ok=True)
    faulty.dashboard.settings.journal.mkdir(parents=True)
    assert confirm(faulty, asked, 400)["code"] == "JournalError"
    assert faulty.get("/faults")["count"] == 2
    assert faulty.get("/journal") == {"entries": []}
