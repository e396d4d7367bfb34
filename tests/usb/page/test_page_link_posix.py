"""The contract of links over the page's own drivers, on the page's Python: one chip after another.

Its tests run in Pyodide under Node (`link_in_pyodide.py`); the chips are models.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from packed_program import pack
from usb.book_rig import Far
from usb.chips.named import plugged
from usb.chips.uart import Settings
from usb.page import node_rig

HERE = Path(__file__).parent
PYODIDE = HERE.parents[2] / "web" / "node_modules" / "pyodide" / "pyodide.mjs"

pytestmark = pytest.mark.realtime


class FarHost(node_rig.Host):
    """The other end of the wire, too, and the hand at the plug."""

    def __init__(self, process: Any) -> None:
        super().__init__(process)
        self._far = Far()
        self._asked: dict[str, Any] | None = None
        self._held = False
        self._answers: dict[bytes, bytes] = {}

    def serve(self, it: dict[str, Any]) -> None:
        data = it.get("data")
        match it["what"]:
            case "plug":
                self._far = Far()
                self.say({"plugged": self.plug(plugged(data, self._far))})
            case "pull":
                self.pull()
                self.say({"pulled": True})
            case "send":
                if self.device:
                    self.device.uart.hear(bytes(data), Settings())
            case "answers":
                pairs = (pair.split("=") for pair in data.split(";"))
                self._answers = {bytes.fromhex(sent): bytes.fromhex(its) for sent, its in pairs}
            case "received":
                self._asked = it
                return
            case "hold":
                self._held = data
            case "claim" if self._held:
                self.answer(it, error="NetworkError")
                return
            case _:
                super().serve(it)
                return
        self.answer(it)

    def give(self) -> None:
        super().give()
        sent = self._far.data
        if self.device and sent in self._answers:
            self._far.data = b""
            self.device.uart.hear(sent + self._answers[sent], Settings())
            super().give()
        it, data = self._asked, self._far.data
        if it and len(data) >= int(it["data"]):
            self._asked, self._far.data = None, b""
            self.answer(it, result=list(data))


def test_the_tests_of_the_link_pass_over_each_chip(tmp_path):
    node_rig.require()
    pack(tmp_path / "program.zip", HERE / "link_in_pyodide.py")
    with node_rig.started(
        "link_in_node.js", tmp_path, tmp_path / "program.zip", PYODIDE
    ) as process:
        code, _, said = FarHost(process).until_done().partition("\n")
    assert code == "0", said
