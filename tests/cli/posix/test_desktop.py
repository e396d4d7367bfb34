"""`mikas dash --desktop` as an icon starts it: a process without a terminal, and a browser."""

from __future__ import annotations

import os
import subprocess
import sys
from contextlib import contextmanager

import httpx
import pytest

from mikas.cli.main import run

pytestmark = pytest.mark.realtime

ME = {"X-Mikas-Client": "tester-0001"}
BROWSER = """\
#!/bin/sh
echo "$1" > "{opened}"
"""


@pytest.fixture
def desktop(tmp_path):
    """A user's desktop: `start` clicks the icon, `page` is the address the browser was given."""
    opened, browser = tmp_path / "opened", tmp_path / "browser"
    os.mkfifo(opened)
    browser.write_text(BROWSER.format(opened=opened))
    browser.chmod(0o755)
    environment = {
        **os.environ,
        "HOME": str(tmp_path),
        "BROWSER": f"{browser} %s",
        "MIKAS_STATE": str(tmp_path / "state"),
        "MIKAS_CONFIG": str(tmp_path / "config.toml"),
        "LC_ALL": "C.UTF-8",
    }

    class Desktop:
        folder = tmp_path

        @contextmanager
        def start(self, *argv):
            command = [sys.executable, "-m", "mikas", "dash", "--desktop", *argv]
            process = subprocess.Popen(
                command,
                env=environment,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
            )
            try:
                yield process
            finally:
                process.kill()
                process.communicate()

        def page(self):
            return opened.read_text().strip()

    return Desktop()


def test_the_second_click_opens_the_page_of_the_first_and_the_button_ends_it(desktop):
    with desktop.start() as first:
        url = desktop.page()
        about = httpx.get(f"{url}api/about").json()
        assert about["desktop"] is True
        with desktop.start("--port", "/dev/nosuch7") as second:
            assert desktop.page() == url
            assert second.wait(60) == 0
        assert httpx.post(f"{url}api/end", headers=ME).status_code == 200
        assert first.wait(60) == 0
        assert not (desktop.folder / "state" / "dashboard.json").exists()


def test_after_a_kill_the_icon_starts_another_one(desktop):
    with desktop.start() as first:
        before = httpx.get(f"{desktop.page()}api/about").json()["instance"]
        first.kill()
        first.wait(60)
    with desktop.start():
        assert httpx.get(f"{desktop.page()}api/about").json()["instance"] != before


def test_two_clicks_at_once_are_one_program(desktop):
    with desktop.start() as one, desktop.start() as other:
        assert desktop.page() == desktop.page()
        assert {one.poll(), other.poll()} >= {None}


def test_what_keeps_it_from_starting_is_a_page(desktop):
    (desktop.folder / "config.toml").write_text('lang = "ru"\nprot = "COM3"\n')
    with desktop.start() as process:
        said = httpx.get(desktop.page())
        assert "mikas не запустился" in said.text
        assert "config.toml" in said.text
        assert "prot" in said.text
        assert process.wait(60) == 2


def test_without_a_browser_there_is_nothing_to_open(capsys, monkeypatch):
    monkeypatch.setattr("mikas.cli.desktop.open_page", lambda _: False)
    assert run(["dash", "--desktop", "--no-browser", "--lang", "en"]) == 2
    assert "omit --no-browser" in capsys.readouterr().err
