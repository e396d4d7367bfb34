"""`mikas ports`: the list, and the udev rules with the user's consent."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest
from cli_harness import is_one_short_paragraph, is_russian

from mikas.cli.commands import ports as command
from mikas.errors import TakenByBrltty
from mikas.link.udev_rules import rules


@pytest.fixture
def file(tmp_path, monkeypatch):
    """Where the rules go; the system is a Linux."""
    file = tmp_path / "etc/udev/rules.d/70-mikas.rules"
    monkeypatch.setattr(command.udev_rules, "FILE", file)
    monkeypatch.setattr(command.udev_rules, "PACKAGED", tmp_path / "usr/70-mikas.rules")
    monkeypatch.setattr("sys.platform", "linux")
    return file


def test_the_rules_are_printed_and_written_after_a_yes(mikas, file):
    mikas.answers("y")
    ran = mikas("ports", "--install-rules")
    assert (ran.status, ran.out) == (0, rules())
    assert file.read_text() == rules()
    assert stat.S_IMODE(file.stat().st_mode) == 0o644
    assert str(file) in ran.err
    assert "plug it in again" in ran.err
    again = mikas("ports", "--install-rules")  # asks nothing
    assert (again.status, again.out) == (0, rules())
    assert "installed already" in again.err
    assert [each.name for each in file.parent.iterdir()] == [file.name]


def test_an_older_file_is_replaced(mikas, file):
    file.parent.mkdir(parents=True)
    file.write_bytes(b"\xff old")
    ran = mikas("ports", "--install-rules", "--yes", "--json")
    assert ran.object == {"schema": 1, "rules": rules(), "path": str(file), "written": True}
    assert file.read_text() == rules()
    assert mikas("ports", "--install-rules", "--json").object["written"] is False


def test_rules_of_the_debian_package_are_enough_unless_an_older_file_hides_them(mikas, file):
    packaged = command.udev_rules.PACKAGED
    packaged.parent.mkdir()
    packaged.write_text(rules())
    ran = mikas("ports", "--install-rules", "--json").object
    assert (ran["path"], ran["written"]) == (str(packaged), False)
    assert not file.exists()
    file.parent.mkdir(parents=True)
    file.write_text("old")
    assert mikas("ports", "--install-rules", "--yes", "--json").object["path"] == str(file)
    assert file.read_text() == rules()


@pytest.mark.parametrize("answer", [None, "n", ""])
def test_nothing_is_written_without_a_yes(mikas, file, answer):
    if answer is not None:
        mikas.answers(answer)
    ran = mikas("ports", "--install-rules", "--lang", "ru")
    assert (ran.status, ran.out) == (6, rules())
    assert "Не подтверждено" in ran.err
    assert not file.exists()


@pytest.mark.parametrize("language", ["en", "ru"])
def test_without_root_the_command_for_root_is_given(mikas, file, monkeypatch, language):
    monkeypatch.setattr(os, "access", lambda *_: False)
    monkeypatch.setattr(os, "geteuid", lambda: 1000, raising=False)
    program = file.parents[3] / "bin/mikas"
    program.parent.mkdir()
    program.touch()
    monkeypatch.setattr("sys.argv", [str(program)])
    ran = mikas("ports", "--install-rules", "--yes", "--lang", language)
    assert (ran.status, ran.out) == (2, rules())
    assert f"sudo {program} ports --install-rules" in ran.err
    assert not file.exists()
    monkeypatch.setattr("sys.argv", ["/x/mikas/__main__.py"])
    assert " -m mikas ports --install-rules" in mikas("ports", "--install-rules").err


def test_a_folder_that_takes_no_file_is_an_error(mikas, file, monkeypatch):
    monkeypatch.setattr(Path, "mkdir", lambda *_, **__: None)
    ran = mikas("ports", "--install-rules", "--yes", "--lang", "ru")
    assert ran.status == 2
    is_russian(ran.err)
    assert "Не удаётся записать правила" in ran.err


def test_other_systems_have_no_udev(mikas, file, monkeypatch):
    monkeypatch.setattr("sys.platform", "win32")
    ran = mikas("ports", "--install-rules", "--yes")
    assert (ran.status, ran.out) == (2, "")
    assert "Only Linux has udev rules" in ran.err
    assert not file.exists()


def test_an_adapter_that_brltty_took_is_in_the_list(mikas, monkeypatch):
    taken = TakenByBrltty(url="", chip="CH340")
    monkeypatch.setattr(command, "adapter_without_port", lambda: taken)
    monkeypatch.setattr(command, "find_ports", list)
    ran = mikas("ports")
    assert ran.status == 0
    is_one_short_paragraph(ran.err)
    assert "(CH340) is plugged in but has no port: brltty" in ran.err
    assert "`mikas ports --install-rules`" in ran.err
    assert "No serial adapter" not in ran.err
