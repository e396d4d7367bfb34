"""The user's folders on Linux are those that platformdirs names, without its import."""

from __future__ import annotations

import sys
from pathlib import Path

import platformdirs
import pytest

from mikas.home import NO_HOME, config_folder, state_folder

pytestmark = pytest.mark.skipif(
    sys.platform in ("win32", "darwin"), reason="there they are platformdirs' own"
)


@pytest.mark.parametrize("named", [None, "", " ", "/somewhere", "/somewhere else/"])
@pytest.mark.parametrize("home", ["/home/anna", "/root"])
def test_they_are_where_platformdirs_has_them(named, home, monkeypatch):
    monkeypatch.setenv("HOME", home)
    for variable in ("XDG_CONFIG_HOME", "XDG_STATE_HOME"):
        monkeypatch.delenv(variable, raising=False)
        if named is not None:
            monkeypatch.setenv(variable, named)
    assert config_folder() == platformdirs.user_config_path("mikas", appauthor=False)
    assert state_folder() == platformdirs.user_state_path("mikas", appauthor=False)


def test_a_user_without_a_home_has_none_but_the_named_ones(monkeypatch):
    monkeypatch.setenv("HOME", "")
    monkeypatch.delenv("XDG_STATE_HOME", raising=False)
    assert state_folder().is_relative_to(NO_HOME)
    monkeypatch.setenv("XDG_STATE_HOME", "/somewhere")
    assert state_folder() == Path("/somewhere/mikas")
