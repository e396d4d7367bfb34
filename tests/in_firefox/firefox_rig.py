"""Firefox, driven by WebDriver BiDi: its own protocol, on a WebSocket.

Playwright, which drives Chromium, sends other browsers commands that Firefox 153 does not know.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import pytest
from websockets.sync.client import ClientConnection, connect

from browser.rig import UNTIL, until

_LISTENS = "WebDriver BiDi listening on "
_LOGGED = "log.entryAdded"
_ASKED = "browsingContext.userPromptOpened"
_ASKS = {"alwaysMatch": {"unhandledPromptBehavior": {"default": "ignore"}}}
_FLAGS = ("--headless", "--no-remote", "--remote-debugging-port", "0", "--profile")
_BUTTON = """name => [...document.querySelectorAll("button")].find(
  it => (it.ariaLabel ?? it.textContent).trim() === name && !it.disabled)"""


def installed() -> str | None:
    """Return the path of the browser."""
    return shutil.which("firefox") or shutil.which("firefox-esr")


def must_not_miss(missing: str) -> None:
    """Skip if something is `missing`; where Firefox is required, that is a failure."""
    if missing and os.environ.get("MIKAS_REQUIRE_FIREFOX"):
        pytest.fail(missing)
    if missing:
        pytest.skip(missing)


class FirefoxTab:
    """A tab: what is done and asked there are functions of JavaScript."""

    def __init__(self, browser: ClientConnection) -> None:
        self._browser = browser
        self._last = 0
        self.complaints: list[str] = []
        """What the browser's console has against the page."""
        self.asked: list[str] = []
        """Of which kind the browser's questions were; the answer is yes."""
        self._call("session.new", capabilities=_ASKS)
        self._call("session.subscribe", events=[_LOGGED, _ASKED])
        self._context = self._call("browsingContext.getTree")["contexts"][0]["context"]

    def goto(self, url: str) -> None:
        self._call("browsingContext.navigate", context=self._context, url=url, wait="complete")

    def reload(self) -> None:
        self._call("browsingContext.reload", context=self._context, wait="complete")

    def evaluate(self, function: str, given: object = None, *, by_hand: bool = False):
        """Return what `function(given)` gives, as JSON has it; `by_hand`: as after a click."""
        answer = self._call(
            "script.callFunction",
            functionDeclaration=f"""async given =>
              JSON.stringify(await ({function})(JSON.parse(given))) ?? "null" """,
            arguments=[{"type": "string", "value": json.dumps(given)}],
            target={"context": self._context},
            awaitPromise=True,
            userActivation=by_hand,
        )
        assert answer["type"] == "success", answer["exceptionDetails"]["text"]
        return json.loads(answer["result"]["value"])

    def until(self, function: str, given: object = None):
        """Wait for what the function, which may be async, gives to be true; give that."""
        return until(self, function, given)

    def press(self, name: str) -> None:
        """Click the first button of that name."""
        self.until(f"name => ({_BUTTON})(name) !== undefined", name)
        self.evaluate(f"name => ({_BUTTON})(name).click()", name, by_hand=True)

    def strike(self, key: str) -> None:
        """Press a key of the keyboard: only then does Firefox ask before the tab is left."""
        strokes = [{"type": kind, "value": key} for kind in ("keyDown", "keyUp")]
        keyboard = {"type": "key", "id": "keyboard", "actions": strokes}
        self._call("input.performActions", context=self._context, actions=[keyboard])

    def _call(self, method: str, **params: object) -> dict:
        wanted = self._send(method, params)
        while True:
            message = json.loads(self._browser.recv(2 * UNTIL / 1000))
            if message.get("method") == _ASKED:
                self.asked.append(message["params"]["type"])
                self._send("browsingContext.handleUserPrompt", {"context": self._context})
            elif message.get("method") == _LOGGED:
                entry = message["params"]
                if entry["level"] in ("error", "warn"):
                    self.complaints.append(entry["text"])
            elif message.get("id") == wanted:
                assert message["type"] == "success", f"{method}: {message.get('message')}"
                return message["result"]

    def _send(self, method: str, params: Mapping[str, object]) -> int:
        self._last += 1
        self._browser.send(json.dumps({"id": self._last, "method": method, "params": params}))
        return self._last


@contextmanager
def firefox_tab(
    program: str, profile: Path, preferences: Mapping[str, object]
) -> Iterator[FirefoxTab]:
    """Start Firefox with a new profile in the folder `profile`."""
    lines = [f"user_pref({json.dumps(it)}, {json.dumps(preferences[it])});" for it in preferences]
    (profile / "user.js").write_text("\n".join(lines), "utf-8")
    command = [program, *_FLAGS, str(profile)]
    pipe, null = subprocess.PIPE, subprocess.DEVNULL
    with subprocess.Popen(command, stdout=null, stderr=pipe, text=True) as browser:
        assert browser.stderr is not None
        said = next((line for line in browser.stderr if line.startswith(_LISTENS)), "")
        reading = threading.Thread(target=browser.stderr.read)  # or it waits for that some day
        reading.start()
        try:
            assert said, "Firefox has ended"
            address = f"{said.removeprefix(_LISTENS).strip()}/session"
            with connect(address, open_timeout=60, max_size=None) as connection:
                yield FirefoxTab(connection)
        finally:
            browser.kill()
            reading.join()
