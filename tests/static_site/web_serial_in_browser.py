"""`mikas.browser.web_serial` in a browser's Python: the contract of links, and what else it does.

`test_web_serial` runs this over Web Serial and over WebUSB (`SCHEME`). Adapters and wires are that
test's (`COMMANDS` there), asked by requests that block this worker: what the browser has to do for
a link is done when the link waits.
"""

from __future__ import annotations

import gc
import io
import os
import time
from contextlib import redirect_stdout

import mikas_host
import pytest
from js import XMLHttpRequest
from pyodide.ffi import run_sync, to_js

from mikas.browser import green_threads
from mikas.browser.suspension import yield_turn

gc.disable()  # as `mikas.browser.start`
green_threads.install(mikas_host, run_sync)

from mikas.browser.web_serial import find_web_ports  # noqa: E402  (as the program: no lock before)
from mikas.errors import BadPortUrl, LinkLost, NoPortGiven, PortFailed, PortNotFound  # noqa: E402
from mikas.link import open_link  # noqa: E402
from mikas.link.reconnecting import ReconnectingPort  # noqa: E402
from mikas.testing.links import FAR, RealTimeContract, Rig  # noqa: E402

SCHEME = os.environ["SCHEME"]
IS_USB = SCHEME == "webusb"
FT232, CH340 = f"{SCHEME}:0403:6001", f"{SCHEME}:1a86:7523"


def ask(what: str, body: bytes = b"") -> bytes:
    request = XMLHttpRequest.new()
    request.open("POST", f"/{what}", False)
    request.responseType = "arraybuffer"
    request.send(to_js(body))
    assert request.status == 200, what
    return request.response.to_bytes()


def command(what: str, *ports: str) -> None:
    """Plug or unplug; wait until the browser has these `ports`."""
    ask(what)
    while {port.url for port in find_web_ports()} != set(ports):
        yield_turn()


class FarEnd:
    def send(self, data: bytes) -> None:
        ask("send", data)

    def received(self, count: int) -> bytes:
        data, until = b"", time.monotonic() + FAR
        while len(data) < count and time.monotonic() < until:
            yield_turn()  # the link itself may write then
            data += ask("arrived")
        return data

    def vanish(self) -> None:
        ask("vanish")


@pytest.fixture(autouse=True)
def _an_ft232():
    command("unplug-all")
    command("plug", FT232)


class TestContract(RealTimeContract):
    @pytest.fixture
    def rig(self):
        with open_link(FT232) as link:
            yield Rig(link, FarEnd())


def test_a_port_is_described_by_its_chip():
    [port] = find_web_ports()
    assert (port.chip, port.description, port.likely) == ("FT232R", "FT232R", True)
    # Over WebUSB the chip hands a message over at its end.
    assert ["browser can't lower it" in quirk.en for quirk in port.quirks] == [True] * (not IS_USB)
    assert (port.vid, port.pid, port.serial_number) == (0x0403, 0x6001, None)
    with open_link(FT232) as link:
        assert link.description == port.description


def test_options_are_those_of_a_serial_port():
    with open_link(f"{FT232}?baud=10400&dtr=0&rts=1") as link:
        assert link.byte_time == 10 / 10400
    with pytest.raises(BadPortUrl):
        open_link(f"{FT232}?parity=even")


def test_the_only_port_needs_no_name():
    with open_link(f"{SCHEME}:"):
        pass
    command("plug-ch340", FT232, CH340)
    with pytest.raises(NoPortGiven) as caught:
        open_link(f"{SCHEME}:")
    assert f"{FT232} (FT232R), {CH340} (CH340)" in str(caught.value)


def test_like_adapters_keep_their_names_until_they_are_unplugged():
    command("plug-second", FT232, f"{FT232}:2")
    command("vanish", f"{FT232}:2")
    with pytest.raises(PortNotFound, match=f"{FT232}:2"):
        open_link(FT232)
    with open_link(f"{FT232}:2"):
        pass
    command("plug", FT232, f"{FT232}:2")


def test_an_open_port_is_busy():
    with open_link(FT232), pytest.raises(PortFailed, match="open already"):
        open_link(FT232)
    with open_link(FT232):
        pass


def test_without_an_adapter_the_user_is_told_to_choose_one():
    command("vanish")
    with pytest.raises(PortNotFound, match="pick it in the browser's list"):
        open_link(FT232)
    command("plug-ch340", CH340)
    with pytest.raises(PortNotFound, match=CH340):
        open_link(FT232)


def test_an_adapter_that_was_pulled_is_found_again():
    port = ReconnectingPort(f"{FT232}?rts=1", find=find_web_ports)
    link = port.open()
    command("vanish")
    with pytest.raises(LinkLost, match="unplugged"):
        link.read(link.now())
    command("plug-ch340", CH340)
    with pytest.raises(PortNotFound):
        port.open()
    command("plug", FT232, CH340)
    with port.open() as link:
        ask("send", b"\x07")
        assert link.read(link.now() + FAR).data == b"\x07"


def test_another_adapter_of_the_kind_is_not_taken_for_the_one_that_was_pulled():
    command("plug-second", FT232, f"{FT232}:2")
    port = ReconnectingPort(FT232, find=find_web_ports)
    port.open().close()
    command("vanish", f"{FT232}:2")
    with pytest.raises(PortNotFound, match="same kind"):
        port.open()


def run() -> str:
    """Run the tests; return pytest's code and, in the next lines, what it says."""
    said = io.StringIO()
    with redirect_stdout(said):
        options = ["-q", "-p", "no:cacheprovider", "-p", "no:faulthandler", "--capture=sys"]
        code = pytest.main([*options, __file__])
    return f"{int(code)}\n{said.getvalue()}"
