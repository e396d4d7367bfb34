"""Where a decoder is put, what it replaces, and whether its program runs."""

from __future__ import annotations

import os
import subprocess

import pytest

from mikas.dissectors import installing
from mikas.dissectors.installing import install, is_running, plugin_file
from mikas.errors import UsageError

MARK = "-- ours"


def test_the_folder_is_made_and_only_a_difference_is_written(tmp_path):
    file = tmp_path / "a" / "b" / "mikas.lua"
    assert install(file, "-- ours 1", MARK)
    assert not install(file, "-- ours 1", MARK)
    assert install(file, "-- ours 2", MARK)
    assert file.read_text("utf-8") == "-- ours 2"
    assert [each.name for each in file.parent.iterdir()] == ["mikas.lua"]


@pytest.mark.parametrize("content", [b"", b"-- theirs", b"\xff\xfe -- ours"])
def test_a_file_of_another_author_is_left(tmp_path, content):
    file = tmp_path / "mikas.lua"
    file.write_bytes(content)
    with pytest.raises(UsageError, match="not written by mikas"):
        install(file, "-- ours", MARK)
    assert file.read_bytes() == content


@pytest.mark.posix  # pipes with a name
def test_a_pipe_is_left_and_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "mikas.lua")
    with pytest.raises(UsageError, match="not written by mikas"):
        install(tmp_path / "mikas.lua", "-- ours", MARK)


def test_the_systems_reason_is_told(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(UsageError, match="file"):
        install(tmp_path / "file" / "mikas.lua", "-- ours", MARK)
    (tmp_path / "mikas.lua").mkdir()
    with pytest.raises(UsageError, match=r"mikas\.lua"):
        install(tmp_path / "mikas.lua", "-- ours", MARK)


@pytest.mark.parametrize(
    ("system", "expected"),
    [
        ("linux", "home/.local/lib/wireshark/plugins/mikas.lua"),
        ("darwin", "home/.local/lib/wireshark/plugins/mikas.lua"),
        ("win32", "roaming/Wireshark/plugins/mikas.lua"),
    ],
)
def test_wiresharks_folder_of_each_system(tmp_path, monkeypatch, system, expected):
    monkeypatch.setattr("sys.platform", system)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("USERPROFILE", str(tmp_path / "home"))
    monkeypatch.setenv("APPDATA", str(tmp_path / "roaming"))
    assert plugin_file() == tmp_path / expected


def test_without_appdata_it_is_in_the_usual_place(tmp_path, monkeypatch):
    monkeypatch.setattr("sys.platform", "win32")
    monkeypatch.delenv("APPDATA", raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("USERPROFILE", str(tmp_path))
    assert plugin_file() == tmp_path / "AppData/Roaming/Wireshark/plugins/mikas.lua"


def test_a_running_program_is_seen_in_proc(tmp_path, monkeypatch):
    for number, name in (("1", "systemd"), ("77", "wireshark")):
        (tmp_path / number).mkdir()
        (tmp_path / number / "comm").write_text(f"{name}\n")
    (tmp_path / "78").mkdir()  # it has just ended
    monkeypatch.setattr(installing, "_PROC", tmp_path)
    assert is_running("wireshark")
    assert not is_running("pulseview")


@pytest.mark.parametrize(
    ("system", "printed"),
    [
        ("win32", '"System","4","Services","0","8 K"\r\n"Wireshark.exe","9","Console","1","8 K"'),
        ("darwin", "/sbin/launchd\n/Applications/Wireshark.app/Contents/MacOS/Wireshark\n"),
    ],
)
def test_a_running_program_is_seen_elsewhere(tmp_path, monkeypatch, system, printed):
    monkeypatch.setattr("sys.platform", system)
    monkeypatch.setattr(installing, "_PROC", tmp_path / "none")
    monkeypatch.setattr(installing, "_printed", lambda *command: printed)
    assert is_running("wireshark")
    assert not is_running("shark")


def test_where_the_system_does_not_tell_nothing_runs(tmp_path, monkeypatch):
    def fails(*command):
        raise subprocess.CalledProcessError(1, command)

    monkeypatch.setattr(installing, "_PROC", tmp_path / "none")
    monkeypatch.setattr(installing, "_printed", fails)
    assert not is_running("wireshark")
