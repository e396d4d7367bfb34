"""A browser whose memory is its own, asked by its debugging pipe for no more than a bench needs.

Playwright follows the network of all that it opens: of each file that a page or a worker of it
loads, the browser then keeps the bytes, in the page's own process. Those of this site are 22 MiB,
and as many again of a second worker. People's browsers keep none.
"""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path
from time import monotonic, sleep
from typing import Any, BinaryIO

_LOOK = 0.05  # s between two looks for what is waited for
_PATIENCE = 60.0  # s


class PlainPage:
    """The one page of a browser, by the streams to and from its debugging pipe."""

    def __init__(self, to_browser: BinaryIO, from_browser: BinaryIO) -> None:
        self._to, self._from = to_browser, from_browser
        self._numbers = count(1)
        self._session: dict[str, str] = {}
        self._workers: list[dict[str, str]] = []
        targets = self.send("Target.getTargets")["targetInfos"]
        page = next(it["targetId"] for it in targets if it["type"] == "page")
        answer = self.send("Target.attachToTarget", targetId=page, flatten=True)
        self._session = {"sessionId": answer["sessionId"]}

    def send(self, method: str, **parameters: object) -> dict[str, Any]:
        """Return the browser's answer; raises `RuntimeError` with its own words."""
        return self._ask(self._session, method, parameters)

    def _ask(
        self, session: Mapping[str, str], method: str, parameters: Mapping[str, object]
    ) -> dict[str, Any]:
        number = next(self._numbers)
        message = {"id": number, "method": method, "params": parameters, **session}
        self._to.write(json.dumps(message).encode() + b"\0")
        self._to.flush()
        while (answer := self._read()).get("id") != number:
            pass
        if "error" in answer:
            raise RuntimeError(f"{method}: {answer['error']}")
        result: dict[str, Any] = answer["result"]
        return result

    def collect_garbage(self) -> None:
        """Have the JavaScript of the page and of its workers collect what nothing holds."""
        attached = {"waitForDebuggerOnStart": False, "flatten": True}
        self.send("Target.setAutoAttach", autoAttach=True, **attached)  # answers after the workers
        for session in (*self._workers, self._session):
            # Twice: what JavaScript holds of the browser's own objects goes after it.
            for _ in range(2):
                self._ask(session, "HeapProfiler.collectGarbage", {})
        self.send("Target.setAutoAttach", autoAttach=False, **attached)
        self._workers.clear()

    def evaluate(self, expression: str) -> object:
        """Return the value of a JavaScript expression in the page, as JSON has it."""
        asked = {"expression": expression, "awaitPromise": True, "returnByValue": True}
        answer = self.send("Runtime.evaluate", **asked)
        if "exceptionDetails" in answer:
            raise RuntimeError(f"{expression}: {answer['exceptionDetails']}")
        return answer["result"].get("value")

    def wait_for(self, expression: str) -> None:
        """Wait until the expression is true; an error while a page loads is as false."""
        end = monotonic() + _PATIENCE
        while monotonic() < end:
            with suppress(RuntimeError):
                if self.evaluate(f"Boolean({expression})"):
                    return
            sleep(_LOOK)
        raise TimeoutError(expression)

    def press(self, button: str) -> None:
        """Press the button of that name as soon as there is one."""
        found = (
            '[...document.querySelectorAll("button")].find((it) => '
            f'(it.getAttribute("aria-label") ?? it.textContent).trim() === {json.dumps(button)})'
        )
        self.wait_for(found)
        self.evaluate(f"{found}.click()")

    def _read(self) -> dict[str, Any]:
        parts = bytearray()
        while (byte := self._from.read(1)) != b"\0":
            if not byte:
                raise EOFError("the browser has ended")
            parts += byte
        message: dict[str, Any] = json.loads(parts)
        if message.get("method") == "Target.attachedToTarget":
            self._workers.append({"sessionId": message["params"]["sessionId"]})
        return message


@contextmanager
def plain_browser(
    program: str, profile: Path, flags: Sequence[str], phone: Mapping[str, Any]
) -> Iterator[PlainPage]:
    """A browser that has been started with `profile`, its page of the size and name of `phone`."""
    (theirs_in, ours_out), (ours_in, theirs_out) = os.pipe(), os.pipe()
    command = [
        *("bash", "-c", f'exec "$@" 3<&{theirs_in} 4>&{theirs_out}', "bash", program, *flags),
        *("--remote-debugging-pipe", f"--user-data-dir={profile}", "about:blank"),
    ]
    process = subprocess.Popen(
        command,
        pass_fds=(theirs_in, theirs_out),
        stderr=subprocess.DEVNULL,
    )
    os.close(theirs_in)
    os.close(theirs_out)
    with os.fdopen(ours_out, "wb") as to_browser, os.fdopen(ours_in, "rb") as from_browser:
        page = PlainPage(to_browser, from_browser)
        size = {**phone["viewport"], "deviceScaleFactor": phone["device_scale_factor"]}
        page.send("Emulation.setDeviceMetricsOverride", **size, mobile=phone["is_mobile"])
        page.send("Emulation.setTouchEmulationEnabled", enabled=phone["has_touch"])
        page.send("Emulation.setUserAgentOverride", userAgent=phone["user_agent"])
        try:
            yield page
        finally:
            with suppress(EOFError, OSError):
                page.send("Browser.close")
            process.wait(_PATIENCE)
