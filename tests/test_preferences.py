"""The language of a person who has named none, one in the environment, or one in the file."""

from __future__ import annotations

import pytest

from mikas.errors import UsageError
from mikas.preferences import config_path, parsed_config, user_language


@pytest.fixture
def config(tmp_path, monkeypatch):
    for name in ("MIKAS_LANG", "LC_ALL", "LC_MESSAGES"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("LANG", "C.UTF-8")
    monkeypatch.setenv("MIKAS_CONFIG", str(tmp_path / "config.toml"))
    return tmp_path / "config.toml"


def test_the_language_is_the_first_that_is_named(config, monkeypatch):
    assert user_language() == "en"
    monkeypatch.setenv("LANG", "ru_RU.UTF-8")
    assert user_language() == "ru"
    config.write_text('lang = "en"\n')
    assert user_language() == "en"
    monkeypatch.setenv("MIKAS_LANG", "ru")
    assert user_language() == "ru"


@pytest.mark.parametrize("content", [b"lang = ", b"lang = 5", b"\xff", b"[lang]"])
def test_a_wrong_file_names_no_language(config, content):
    config.write_bytes(content)
    assert user_language() == "en"


@pytest.mark.posix
def test_a_file_that_can_not_be_looked_for_is_an_error_in_words(monkeypatch):
    """As in the folder of another user, which a service was given; root may enter all of them."""
    monkeypatch.setenv("MIKAS_CONFIG", f"/tmp/{'x' * 300}.toml")
    monkeypatch.setenv("LC_ALL", "ru_RU.UTF-8")
    monkeypatch.delenv("MIKAS_LANG", raising=False)
    assert user_language() == "ru"
    with pytest.raises(UsageError, match=r"The config file /tmp/xxx.*: File name too long"):
        parsed_config(config_path())


def test_without_a_file_there_are_no_settings(config):
    assert config_path() == config
    assert parsed_config(config) == {}
