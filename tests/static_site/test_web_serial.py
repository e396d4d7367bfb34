"""The link over Web Serial and over WebUSB: its tests run in Chromium, in Pyodide."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from packed_program import pack

from .computer_rig import CH340, FT232, Computer
from .usb_sockets_rig import UsbByHand, UsbSockets
from .wire_rig import Wire

HERE = Path(__file__).parent
MODULES = HERE.parents[1] / "web" / "node_modules"
RUN = """scheme => new Promise(resolve => {
  const worker = new Worker(`worker.js?${scheme}`, { type: "module" })
  worker.onmessage = ({ data }) => resolve(data)
  worker.onerror = ({ message }) => resolve(message)
})"""


def by_serial(computer: Computer) -> list[Wire]:
    return [Wire(computer, each) for each in (FT232, FT232, CH340)]


def by_usb(sockets: UsbSockets) -> list[UsbByHand]:
    return [UsbByHand(sockets, each) for each in ("FT232R", "FT232R", "CH340")]


def commands(wires: list[Wire] | list[UsbByHand]) -> dict[str, Callable[[bytes], bytes | None]]:
    """Return what the tests in the browser can ask for."""
    wires = dict(zip(("/plug", "/plug-second", "/plug-ch340"), wires, strict=True))
    first = wires["/plug"]

    def unplug_all(_: bytes = b"") -> None:
        for each in wires.values():
            each.vanish()

    unplug_all()
    return {name: lambda _, wire=wire: wire.put_back() for name, wire in wires.items()} | {
        "/vanish": lambda _: first.vanish(),
        "/unplug-all": unplug_all,
        "/send": first.send,
        "/arrived": lambda _: first.arrived(),
    }


@pytest.mark.realtime
@pytest.mark.parametrize("scheme", ["webserial", "webusb"])
def test_the_tests_of_the_link_pass_in_the_browser(
    computer, usb_sockets, host, visitor, tmp_path, scheme
):
    folder = tmp_path / "pages"
    folder.mkdir()
    (folder / "index.html").write_text("<!doctype html><link rel=icon href=data:,>", "ascii")
    (folder / "pyodide").symlink_to(MODULES / "pyodide")
    pack(folder / "program.zip", HERE / "web_serial_in_browser.py")
    rolldown = [MODULES / ".bin" / "rolldown", HERE / "python_worker.js", "--format", "esm"]
    subprocess.run([*rolldown, "--file", folder / "worker.js"], check=True, capture_output=True)
    asked = commands(by_usb(usb_sockets) if scheme == "webusb" else by_serial(computer))
    tab = visitor(host(folder, asked).url)
    tab.page.goto(tab.url)
    code, _, said = tab.page.evaluate(RUN, scheme).partition("\n")
    asked["/unplug-all"](b"")
    assert code == "0", said
