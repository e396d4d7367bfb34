"""Settings at the start: the page's language, the folder of recordings, addresses in texts."""

from __future__ import annotations

import re
from base64 import b64encode
from hashlib import sha256

import pytest

from dashboard.rig import rig
from mikas.cli.language import detect_language, requested_language, set_language
from mikas.cli.options.dashboard import DashboardOptions
from mikas.errors import UsageError


def test_the_page_begins_in_the_language_of_the_command_line(tmp_path):
    (tmp_path / "index.html").write_text('<!doctype html><html lang="en"><p>the page')
    with rig(tmp_path, None, page=tmp_path, language="ru") as it:
        page = it.client.get("/")
    assert page.text == '<!doctype html><html data-language="ru" lang="en"><p>the page'
    assert page.headers["cache-control"] == "no-cache"


@pytest.mark.parametrize(("argv", "wished"), [(["dash", "--lang", "ru"], "ru"), (["dash"], None)])
def test_a_language_that_was_named_reaches_the_page(argv, wished, tmp_path, monkeypatch):
    for name in ("MIKAS_LANG", "LC_ALL", "LC_MESSAGES"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("LANG", "ru_RU.UTF-8")
    monkeypatch.setenv("MIKAS_CONFIG", str(tmp_path / "none.toml"))
    set_language(detect_language(argv))
    assert requested_language() == wished
    set_language("en")


def test_an_address_with_nothing_behind_it_is_a_page_in_words(shared_off):
    page = shared_off.client.get("/nothing", headers={"Accept": "text/html"})
    assert page.status_code == 404
    assert "/nothing" in page.text
    assert "list" not in page.text.replace("what the API answers", "")
    style = re.search("<style>(.*)</style>", page.text)[1]
    digest = b64encode(sha256(style.encode()).digest()).decode()
    assert f"style-src 'sha256-{digest}'" in page.headers["content-security-policy"]
    assert "X-Frame-Options" in page.headers
    error = shared_off.get("/nothing", 404)
    assert error["code"] == "NotFound"
    assert "Reload" not in error["en"]


def test_an_unusable_folder_is_an_error_at_the_start(tmp_path):
    (tmp_path / "file").touch()
    options = {"host_port": None, "lan": False, "lan_control": False, "no_browser": True}
    with pytest.raises(UsageError, match="--record"):
        DashboardOptions(**options, record=tmp_path / "file" / "x" / "y")
    assert DashboardOptions(**options, record=tmp_path / "new" / "x").record
    assert not (tmp_path / "new").exists()


def test_an_unusable_folder_is_a_problem_in_the_list(tmp_path):
    with rig(tmp_path, None) as it:
        assert it.get("/recordings")["problem"] is None
        it.dashboard.settings.recordings.write_text("in the way")
        problem = it.get("/recordings")["problem"]
        assert "--record" in problem["en"]
        assert problem["ru"]
