"""Every example runs as it stands, against the virtual car on simulated time."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"
EXPECTED = {
    "read_values.py": "TWAT         86 °C   bytes 7e",
    "log_and_plot.py": "360 samples in drive.csv",
    "erase_faults.py": "stored now: []",
    "dump_memory.py": "4096 bytes in code-8000.bin",
    "async_watch.py": "FREQ 840 rpm",
    "own_catalog/read_own.py": "TWAT 86 °C danger above 105",
}


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    """Run an example in an empty folder; returns its output."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("mikas.client.gate.default_journal", lambda: tmp_path / "journal.jsonl")
    monkeypatch.setattr("mikas.client.limits.default_folder", lambda: tmp_path / "units")
    monkeypatch.setattr("builtins.input", lambda _: "y")

    def run(name):
        monkeypatch.setattr(sys, "argv", [name])
        runpy.run_path(str(EXAMPLES / name), run_name="__main__")
        return capsys.readouterr().out

    return run


def test_every_example_is_run():
    scripts = {path.relative_to(EXAMPLES).as_posix() for path in EXAMPLES.rglob("*.py")}
    assert scripts == set(EXPECTED)


@pytest.mark.parametrize("name", EXPECTED)
def test_it_runs(run, name):
    assert EXPECTED[name] in run(name)


@pytest.mark.parametrize("name", EXPECTED)
def test_it_is_short(name):
    assert 10 <= len((EXAMPLES / name).read_text("utf-8").splitlines()) <= 40


@pytest.mark.parametrize("name", EXPECTED)
def test_the_guide_names_it(name):
    guide = (EXAMPLES / "README.md").read_text("utf-8")
    assert f"]({name})" in guide or f"]({Path(name).parent}/)" in guide


def test_what_was_logged_is_drawn(run, tmp_path):
    run("log_and_plot.py")
    header, *rows = (tmp_path / "drive.csv").read_text("utf-8").splitlines()
    assert header == "time,FREQ,TWAT"
    assert len(rows) == 360
    assert (tmp_path / "drive.svg").read_text("utf-8").count("<polyline") == 2


def test_what_is_not_confirmed_is_not_erased(run, monkeypatch):
    monkeypatch.setattr("builtins.input", lambda _: "")
    assert "nothing was changed" in run("erase_faults.py")
