"""The contract of links over the page's drivers, run by `link_in_node.js` on the page's Python.

Chips, wires and the hand at the plug are `node_rig.py`'s, asked by `mikas_host.far`.
"""

from __future__ import annotations

import gc
import io
from contextlib import closing, redirect_stdout

import mikas_host
import pytest
from pyodide.ffi import run_sync, to_js

from mikas.browser import green_threads
from mikas.browser.suspension import suspend, yield_turn

gc.disable()  # as `mikas.browser.start`
green_threads.install(mikas_host, run_sync)

# As the program does it: what follows makes no lock before.
from mikas import tester as package  # noqa: E402
from mikas.browser.web_serial import find_web_ports  # noqa: E402
from mikas.commands import Datum, ReadParameters  # noqa: E402
from mikas.errors import DamagedResponse, LinkLost, PortFailed, PortNotFound  # noqa: E402
from mikas.framing import encode  # noqa: E402
from mikas.link import CaptureTee, LinkWrapper, open_link  # noqa: E402
from mikas.link.reconnecting import ReconnectingPort  # noqa: E402
from mikas.testing.links import FAR, RealTimeContract, Rig  # noqa: E402

CHIPS = {
    "FT232R": "webusb:0403:6001",
    "CH340": "webusb:1a86:7523",
    "CP2102": "webusb:10c4:ea60",
    "PL2303HX": "webusb:067b:2303",
    "CH343": "webusb:1a86:55d3",
}
FT232R = CHIPS["FT232R"]


def ask(what: str, data=""):
    data = to_js(data) if isinstance(data, bytes) else data
    return suspend(mikas_host.far.ask(what, data).promise)


def plug(chip: str) -> str:
    """Plug a chip in; return its port once the page has it."""
    ask("plug", chip)
    while not (ports := find_web_ports()):
        yield_turn()
    return ports[0].url


class FarEnd:
    def send(self, data: bytes) -> None:
        ask("send", data)

    def received(self, count: int) -> bytes:
        return bytes(ask("received", str(count)))

    def vanish(self) -> None:
        ask("pull")


@pytest.fixture(autouse=True)
def _nothing_is_left():
    yield
    ask("pull")


class TestContract(RealTimeContract):
    @pytest.fixture(params=CHIPS)
    def rig(self, request):
        url = plug(request.param)
        assert url == CHIPS[request.param]
        with open_link(url) as link:
            yield Rig(link, FarEnd())


def test_an_ftdi_may_be_late_within_a_message():
    for chip, late in {"FT232R": 0.017, "FT232AM": 0.017, "CH340": 0.002}.items():
        with open_link(plug(chip)) as link:
            assert link.granularity == pytest.approx(late)
        ask("pull")


def test_a_chip_that_makes_another_rate_is_refused_with_it():
    url = plug("CP2102")
    with pytest.raises(PortFailed, match="CP210x can't do 10400 bit/s: it would make 14400"):
        open_link(f"{url}?baud=10400")
    with open_link(url) as link:
        assert link.baud == 9600


def test_a_device_that_another_has_is_named_with_the_cable_that_will_do():
    url = plug("CH340")
    ask("hold", True)
    with pytest.raises(PortFailed, match="CH340 is in use") as caught:
        open_link(url)
    assert "A cable with an FT232R will do" in str(caught.value)
    ask("hold", False)
    with open_link(url):
        pass


class Counting(LinkWrapper):
    """A link that counts the requests that it sent by itself."""

    by_itself = 0

    def take_back(self):
        written = self.link.take_back()
        self.by_itself += written is not None
        return written


class Times(list):
    def record(self, direction, data, time):
        self.append((direction.value, bytes(data), time))


DATA = {0x1A: b"\x5a", 0x1E: b"\x8a", 0x3F: b"\x0d\x40"}


def of(code: int) -> ReadParameters:
    return ReadParameters((Datum(code, len(DATA[code])),))


@pytest.fixture
def tester(request):
    link = Counting(open_link(plug(request.param)))
    answers = {b"\x01": b"\x09"} | {of(code).body(): data for code, data in DATA.items()}
    pairs = (f"{encode(body).hex()}={encode(data).hex()}" for body, data in answers.items())
    ask("answers", ";".join(pairs))
    with closing(package.Tester(link)) as it:
        it.connect()
        yield it


@pytest.mark.parametrize("tester", CHIPS, indirect=True)
def test_the_next_request_goes_out_at_the_last_byte_of_an_answer(tester):
    times, link = Times(), tester.link
    tester.wrap_link(lambda link: CaptureTee(link, times))
    codes = [*DATA, *DATA, *DATA]
    for code, following in zip(codes, codes[1:] + codes[:1], strict=True):
        tester.announce(of(following))
        assert tester.request(of(code)) == (DATA[code],)
    tester.settle()
    assert link.by_itself == len(codes)
    passed = [time for *_, time in times[1:]]  # the first one is written by Python
    assert passed == sorted(passed)
    sent = [n for n, (direction, *_) in enumerate(times) if direction == "sent"]
    for n in sent[1:]:  # nothing comes between the end of an answer and the next request
        assert times[n - 1][0] == "received"
        assert times[n - 1][1].endswith(b"\r")


@pytest.mark.parametrize("tester", ["FT232R"], indirect=True)
def test_after_a_damaged_answer_nothing_goes_out_by_itself(tester):
    wire = encode(of(0x1E).body())
    ask("answers", f"{wire.hex()}=8a770d;01ff0d=09f70d;{encode(of(0x1A).body()).hex()}=5aa60d")
    tester.announce(of(0x1A))
    with pytest.raises(DamagedResponse):
        tester.exchange(of(0x1E), retries=0)
    assert tester.link.by_itself == 0
    assert tester.request(of(0x1A)) == (DATA[0x1A],)


def test_an_adapter_that_was_pulled_is_found_again():
    port = ReconnectingPort(f"{plug('FT232R')}?rts=1", find=find_web_ports)
    link = port.open()
    ask("pull")
    with pytest.raises(LinkLost, match="unplugged"):
        link.read(link.now() + FAR)
    with pytest.raises(PortNotFound):
        port.open()
    plug("FT232R")
    with port.open() as link:
        ask("send", b"\x07")
        assert link.read(link.now() + FAR).data == b"\x07"


def run() -> str:
    """Run the tests; return pytest's code and, in the next lines, what it says."""
    said = io.StringIO()
    with redirect_stdout(said):
        options = ["-q", "-p", "no:cacheprovider", "-p", "no:faulthandler", "--capture=sys"]
        code = pytest.main([*options, __file__])
    return f"{int(code)}\n{said.getvalue()}"
