"""`mikas`: a fixture that runs command lines against a virtual ECU on simulated time."""

from __future__ import annotations

import pytest
from cli_harness import SIM, Mikas, NoTerminal

from mikas.cli.language import set_language


@pytest.fixture
def mikas(capsys, monkeypatch, tmp_path):
    home = tmp_path / "home"
    home.mkdir()
    for name in ("MIKAS_CONFIG", "MIKAS_LANG", "LC_ALL", "LC_MESSAGES", "NO_COLOR"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", str(home))
    monkeypatch.setenv("USERPROFILE", str(home))
    monkeypatch.setenv("XDG_STATE_HOME", str(home / "state"))
    monkeypatch.setenv("XDG_CONFIG_HOME", str(home / "config"))
    monkeypatch.setenv("MIKAS_PORT", SIM)
    monkeypatch.setenv("LANG", "C.UTF-8")
    monkeypatch.setenv("MIKAS_STATE", str(home / "state/mikas"))
    monkeypatch.setattr("sys.stdin", NoTerminal())
    monkeypatch.chdir(tmp_path)
    yield Mikas(capsys, monkeypatch, home)
    set_language("en")
