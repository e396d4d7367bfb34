"""What the shell is offered: commands, and names of channels as people use them."""

from __future__ import annotations

import pytest

from mikas.cli import completion
from mikas.cli.main import cli


@pytest.fixture
def offered(monkeypatch, capsys):
    def ask(line: str) -> list[str]:
        monkeypatch.setenv(completion.VARIABLE, "bash_complete")
        monkeypatch.setenv("COMP_WORDS", line)
        monkeypatch.setenv("COMP_CWORD", str(line.count(" ")))
        assert completion.is_asked()
        assert completion.answer(cli) == 0
        return [each.removeprefix("plain,") for each in capsys.readouterr().out.split()]

    return ask


def test_names_of_channels_are_completed_by_any_of_their_names(offered):
    assert offered("mikas read fr") == ["FREQ", "FREQX"]
    assert "обороты" in offered("mikas watch об")
    assert offered("mikas log TWAT batt_") == ["batt_v"]
    assert "TWAT" in offered("mikas export a.pcapng tw")
    assert "TWAT" in offered("mikas write tw")


def test_commands_are_completed_and_an_error_completes_nothing(offered, monkeypatch):
    assert offered("mikas re") == ["read", "report"]
    assert "demo" in offered("mikas ")
    monkeypatch.setenv(completion.VARIABLE, "nonsense")
    assert completion.answer(cli) == 1
