"""What can't be kept is said once in each run of the program, to whoever is there for it."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
import threading

import pytest

from mikas import unkept
from mikas.errors import EcuRefused, UsageError, naming_file
from mikas.i18n import Text

FRAMES = Text("Frames stay unsaved in {place} ({why}).", "Кадры в {place} не сохранить ({why}).")
OTHERS = Text("Others stay unsaved in {place} ({why}).", "Прочее в {place} не сохранить ({why}).")


def fail(sentence, place, error):
    with unkept.saying_once(sentence, place):
        raise error


def full(place):
    return OSError(errno.ENOSPC, "No space left on device", str(place / "a" / "1.json"))


def test_each_kind_is_said_once_in_a_run_with_its_place_and_the_reason_of_the_system(tmp_path):
    said = []
    for _ in range(2):
        with unkept.said_to(said.append):
            assert unkept.sentences() == []
            for _ in range(3):
                fail(FRAMES, tmp_path, full(tmp_path))
                fail(OTHERS, tmp_path, PermissionError(errno.EACCES, "Permission denied"))
            assert unkept.sentences() == said[-2:]
    assert unkept.sentences() == []
    frames, others = said[:2]
    assert said == [frames, others] * 2
    assert frames.en.startswith(f"Frames stay unsaved in {tmp_path} (No space left on device")
    assert frames.ru.startswith(f"Кадры в {tmp_path} не сохранить (диск заполнен")
    assert others.ru == f"Прочее в {tmp_path} не сохранить (нет прав доступа)."


def test_the_reason_is_that_of_the_system_also_behind_an_error_that_names_the_file(tmp_path):
    said = []
    with unkept.said_to(said.append):
        with unkept.saying_once(FRAMES, tmp_path), naming_file(tmp_path / "a"):
            (tmp_path / "a" / "b").mkdir()
        fail(OTHERS, tmp_path, EcuRefused())
    assert said[0].en == f"Frames stay unsaved in {tmp_path} (No such file or directory)."
    assert said[1].en == f"Others stay unsaved in {tmp_path} ({EcuRefused().reason.en})."


def test_many_threads_say_it_once(tmp_path):
    said, begin = [], threading.Barrier(16)

    def write():
        begin.wait()
        fail(FRAMES, tmp_path, full(tmp_path))

    with unkept.said_to(said.append):
        threads = [threading.Thread(target=write) for _ in range(16)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert len(said) == 1


def test_a_bug_and_ctrl_c_pass(tmp_path):
    for error in (ZeroDivisionError(), KeyboardInterrupt()):
        with pytest.raises(type(error)):
            fail(FRAMES, tmp_path, error)
    assert unkept.sentences() == []


PROGRAM = """
import logging, sys
{begin}
import mikas
for _ in range(2):
    with mikas.connect("sim:?clock=simulated&max_list=9") as ecu:
        ecu.read()
        ecu.set_list("TWAT")
"""


@pytest.mark.parametrize("begin", ["", "logging.basicConfig()"])
def test_the_library_is_silent_and_warns_once_in_its_log(tmp_path, begin):
    (tmp_path / "units").write_text("in the place of the folder")
    (tmp_path / "journal.jsonl").touch()
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM.format(begin=begin)], check=True, capture_output=True,
        env={**os.environ, "MIKAS_STATE": str(tmp_path)}, text=True,
    )  # fmt: skip
    said = done.stderr.splitlines()
    if not begin:
        assert said == []
        return
    limits, names = said
    assert limits.startswith("WARNING:mikas:What was learnt")
    assert names.startswith("WARNING:mikas:The names")
    assert str(tmp_path / "units") in limits


def test_details_of_an_error_that_names_no_file_stay(tmp_path):
    said = []
    with unkept.said_to(said.append):
        fail(FRAMES, tmp_path, UsageError(problem=Text("too long", "слишком длинно")))
    assert said[0].ru == f"Кадры в {tmp_path} не сохранить (слишком длинно)."
