"""The site in Firefox, which opens a kept file only once and forgets the chosen adapter."""

from __future__ import annotations

import threading

import pytest
from tools.site.serve import server_of

from static_site.site_rig import ASK, BUILT, KEPT, RECORDED, missing

from .firefox_rig import firefox_tab, installed, must_not_miss

pytestmark = pytest.mark.realtime

JSPI = "() => 'Suspending' in WebAssembly"
RUNS = "() => document.querySelector('header[data-line]') !== null"
LINE = "line => document.querySelector('header[data-line]')?.dataset.line === line"
KNOWN = "() => document.querySelector('header[data-line]').textContent.includes('Mikas 7.1')"
COOLANT = "() => document.querySelector('#screen [data-value=TWAT]')?.textContent"
EXPORTED = """async name => {
  const answer = await fetch(`api/recordings/${encodeURIComponent(name)}/export?format=csv`)
  return answer.text()
}"""
LONG = 3.0  # s


class Host:
    """Serves the built site until it is stopped."""

    def __init__(self) -> None:
        self._server = server_of(BUILT, 0)
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.01,))
        self._thread.start()
        self.url = f"http://localhost:{self._server.server_port}"

    def stop(self) -> None:
        """Answer no more: the network is gone."""
        if self._thread.is_alive():
            self._server.shutdown()
            self._server.server_close()
            self._thread.join()


@pytest.fixture
def host():
    must_not_miss(missing())
    serving = Host()
    yield serving
    serving.stop()


@pytest.fixture
def tab(tmp_path, host):
    """A tab on the site, with the program in it, in a browser that simulates adapters."""
    program = installed()
    must_not_miss("" if program else "Firefox is not installed")
    with firefox_tab(program, tmp_path, {"dom.webserial.testing.enabled": True}) as opened:
        opened.goto(f"{host.url}/#/connection")
        must_not_miss("" if opened.evaluate(JSPI) else "Firefox is older than 153")
        opened.until(RUNS)
        opened.until(KEPT)
        yield opened
        assert opened.complaints == []


def recordings(tab) -> list[dict]:
    return tab.evaluate(ASK, "api/recordings")["recordings"]


def recorded(tab, seconds: float) -> float:
    return tab.until(RECORDED, seconds)


def test_the_virtual_car_is_recorded_and_the_recording_survives(tab, host):
    tab.press("Start the virtual car")
    tab.until(KNOWN)
    tab.evaluate("() => { location.hash = '/live' }")
    assert 70 < int(tab.until(COOLANT)) < 110
    tab.strike("r")
    tab.until(LINE, "recording")
    recorded(tab, LONG)
    (growing,) = recordings(tab)
    assert growing["open"]
    long = recorded(tab, 2 * LONG)
    host.stop()
    tab.reload()
    tab.until(RUNS)
    assert tab.asked == ["beforeunload"]
    (kept,) = recordings(tab)
    assert (kept["open"], kept["problem"], kept["gaps"]) == (False, None, 0)
    assert kept["length"] > long - 1
    assert tab.evaluate(EXPORTED, kept["id"]).startswith("Time (msec),TWAT")


def test_a_chosen_adapter_is_opened_heard_and_found_again(tab):
    """The browser's own adapter returns what it is sent, and no unit answers."""
    plug = "navigator.serial.simulateDeviceConnection('one', '/dev/ttyUSB0', 0x0403, 0x6001)"
    tab.evaluate(f"""async () => {{
      await navigator.serial.removeAllMockDevices()
      await {plug}
      navigator.serial.autoselectPorts = true
    }}""")
    tab.press("Choose the cable…")
    tab.until(LINE, "echo-only")
    assert tab.evaluate(ASK, "api/state")["port"] == "webserial:0403:6001"
    tab.evaluate("() => navigator.serial.simulateDeviceDisconnection('one')")
    tab.until(LINE, "no-port")
    tab.evaluate(f"() => {plug}")
    tab.until(LINE, "echo-only")
