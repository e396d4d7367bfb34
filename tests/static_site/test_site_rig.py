"""The rig itself: what the browser makes of its fake adapters, in the page and in a worker."""

from __future__ import annotations

import json

import pytest

from browser.chromium_rig import launched, visits
from browser.rig import until
from mikas.framing import encode

from .computer_rig import CH340, CHOOSING, ORIGIN
from .wire_rig import wire

pytestmark = pytest.mark.realtime

WORKER = """\
onmessage = async ({ data }) => {
  try { postMessage({ done: await eval(`(${data})()`) }) }
  catch (error) { postMessage({ failed: `${error.name}: ${error.message}` }) }
}
"""
ASK = """source => new Promise(resolve => {
  const worker = window.worker ??= new Worker("worker.js")
  worker.onmessage = ({ data }) => resolve(data)
  worker.postMessage(source)
})"""
PORTS = "async () => (await navigator.serial.getPorts()).map(it => it.getInfo().usbProductId)"
FT232_PID, CH340_PID = 0x6001, 0x7523


class InWorker:
    def __init__(self, page):
        self.page = page

    def __call__(self, source: str):
        answer = self.page.evaluate(ASK, source)
        assert "failed" not in answer, answer
        return answer.get("done")

    def until(self, source: str, expected: object) -> None:
        """Ask until the worker answers so; fail after the time that pages have."""
        same = f"""async ([source, expected]) =>
          JSON.stringify((await ({ASK})(source)).done) === expected"""
        until(self.page, same, [source, json.dumps(expected, separators=(",", ":"))])


@pytest.fixture
def page(host, visitor, tmp_path):
    (tmp_path / "index.html").write_text(
        "<!doctype html><title>Ports</title><link rel=icon href=data:,>", "ascii"
    )
    (tmp_path / "worker.js").write_text(WORKER, "ascii")
    tab = visitor(host(tmp_path).url)
    tab.page.goto(ORIGIN)
    return tab.page


@pytest.fixture
def worker(page):
    return InWorker(page)


OPEN = """async () => {
  [self.port] = await navigator.serial.getPorts()
  await port.open({ baudRate: 9600, bufferSize: 16384 })
  self.writer = port.writable.getWriter()
  self.reader = port.readable.getReader()
}"""
WRITE = "() => writer.write(new Uint8Array([1, 2, 255, 13]))"
READ = """async () => {
  const got = []
  while (got.length < 256) got.push(...(await reader.read()).value)
  return got
}"""
ASK_UACC = f"""async () => {{
  const request = {list(encode(bytes([0x61, 0x1E])))}, got = []
  await writer.write(new Uint8Array(request))
  while (got.length < request.length + 3) got.push(...(await reader.read()).value)
  return got[request.length]
}}"""
BREAK = "async () => { for (const it of [true, false]) await port.setSignals({ break: it }) }"
LOST = "() => reader.read().then(() => 'read', error => error.name)"


def test_an_adapter_is_a_port_in_the_page_and_in_a_worker(by_hand, page, worker):
    assert page.evaluate(PORTS) == worker(PORTS) == [FT232_PID]


def test_bytes_pass_both_ways(by_hand, worker):
    worker(OPEN)
    worker(WRITE)
    assert by_hand.received(4) == b"\x01\x02\xff\r"
    by_hand.send(bytes(range(256)))
    assert worker(READ) == list(range(256))
    worker(BREAK)


def test_an_unplugged_adapter_is_lost_and_comes_back(by_hand, worker):
    worker(OPEN)
    by_hand.vanish()
    assert worker(LOST) == "NetworkError"
    worker.until(PORTS, [])
    by_hand.put_back()
    worker.until(PORTS, [FT232_PID])
    worker(OPEN)


def test_two_adapters_are_told_apart(computer, by_hand, worker):
    with wire(computer, CH340):
        worker.until(f"async () => (await ({PORTS})()).sort()", [FT232_PID, CH340_PID])
    worker.until(PORTS, [FT232_PID])


def test_elsewhere_an_adapter_is_chosen_first(computer, by_hand, page, driver, chromium_program):
    page.goto(CHOOSING)
    worker = InWorker(page)
    assert page.evaluate(PORTS) == worker(PORTS) == []
    computer.choose()
    with launched(driver, chromium_program) as browser, visits(browser) as visit:
        page = visit(CHOOSING).page
        page.goto(CHOOSING)
        assert page.evaluate(PORTS) == InWorker(page)(PORTS) == [FT232_PID]


def test_a_unit_answers_with_the_value_that_it_was_set_to(ft232, worker):
    ft232.set("UACC", "8A")
    worker(OPEN)
    assert worker(ASK_UACC) == 0x8A
    ft232.pull()
    assert worker(LOST) == "NetworkError"
    worker.until(PORTS, [])
    ft232.put_back()
    worker.until(PORTS, [FT232_PID])
    worker(OPEN)
    assert worker(ASK_UACC) == 0x8A
