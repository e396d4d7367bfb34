"""No test writes into the state folder of whoever runs it."""

from __future__ import annotations

import pytest


@pytest.fixture(autouse=True)
def own_state(tmp_path_factory, monkeypatch):
    folder = tmp_path_factory.mktemp("state")
    monkeypatch.setattr("mikas.client.gate.default_journal", lambda: folder / "journal.jsonl")
    monkeypatch.setattr("mikas.client.limits.default_folder", lambda: folder / "units")
    return folder
