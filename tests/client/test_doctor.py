"""The connection examined step by step, against everything that can be wrong with it."""

from __future__ import annotations

import re

import pytest
from client_harness import bench, ecu_on

from mikas import commands
from mikas.client import doctor
from mikas.client.connecting import ConnectionOptions
from mikas.client.doctor import STEPS, Step, examine
from mikas.errors import BadPortUrl, PortKind, PortProbed
from mikas.i18n import Text
from mikas.link import Link, open_link
from mikas.link.base import LinkWrapper
from virtual_harness import DATA

ALL = list(STEPS)


class WithChip(LinkWrapper):
    def __init__(self, link: Link, chip: str) -> None:
        super().__init__(link)
        self._chip = chip

    @property
    def chip(self) -> str:
        return self._chip


class Examined:
    def __init__(
        self,
        settings: str = "",
        url: str = "",
        kind: PortKind = PortKind.CABLE,
        baud: int = 9600,
        chip: str = "",
    ) -> None:
        self.kind, self.baud, self.chip = kind, baud, chip
        self.links: list[Link] = []
        self.steps = {
            step.name: step
            for step in examine(
                lambda: self._opened(url or f"sim:?clock=simulated{settings}"),
                ConnectionOptions().create_ecu,
            )
        }

    def _opened(self, url: str) -> Link:
        self.links.append(WithChip(open_link(url), self.chip))
        self.links[-1].baud = self.baud  # so says the port, whatever the wire's pace
        self.links[-1].kind = self.kind
        return self.links[-1]

    @property
    def names(self) -> list[str]:
        return list(self.steps)

    def failed(self) -> Step:
        (step,) = (step for step in self.steps.values() if step.ok is False)
        return step


def test_a_sound_line_passes_every_step():
    found = Examined()
    assert found.names == ALL
    assert all(step.ok for step in found.steps.values())
    assert found.steps["baud"].detail.en == "about 9600 bit/s"
    assert found.steps["latency"].detail == ("2.0 ms a request", "2,0 мс на запрос")
    assert found.steps["ecu"].detail.en == "Mikas 7.1"
    assert found.steps["port"].detail == ("virtual ECU", "виртуальный блок")


def test_a_program_of_root_that_has_the_port_too_is_named(monkeypatch):
    def opened() -> Link:
        link = open_link("sim:?clock=simulated")
        link.url = "/dev/ttyUSB0"
        return link

    busy = PortProbed(url="/dev/ttyUSB0", holder=Text("ModemManager (process 7)", "…"))
    monkeypatch.setattr(doctor, "shared", lambda url, address: busy)
    step = next(iter(examine(opened, ConnectionOptions().create_ecu)))
    assert (step.name, step.ok, step.error) == ("port", None, busy)
    assert "in use by ModemManager (process 7)" in step.detail.en


def test_the_port_is_let_go():
    link = Examined().links[0]
    with pytest.raises(ConnectionError):
        link.write(b"\x01")


def test_an_adapter_without_echo_passes_without_its_baud_rate():
    found = Examined("&echo=0")
    assert found.names == [name for name in ALL if name != "baud"]
    assert all(step.ok for step in found.steps.values())
    assert "keeps the echo" in found.steps["echo"].detail.en


@pytest.mark.parametrize(
    ("settings", "step", "words"),
    [
        ("&supplied=0", "echo", "12 V"),
        ("&lost=1", "ecu", "ignition is off"),
        ("&lost=1&echo=0", "echo", "ignition is off"),
        ("&adapter=elm327", "echo", "ELM327"),
        ("&damaged=1", "ecu", "ground"),
        ("&late=1", "ecu", "did not answer within"),
    ],
)
def test_a_line_without_an_ecu_fails_at_its_step(settings, step, words):
    found = Examined(settings)
    failed = found.failed()
    assert failed.name == step == found.names[-1]
    assert words in failed.detail.en
    for text in failed.detail:
        assert "mikas doctor" not in text  # that is what is running
        assert ". ." not in text
        assert text.rstrip().endswith(".")


def test_a_missing_port_fails_at_the_first_step():
    found = Examined(url="/dev/nosuch")
    assert found.names == ["port"]
    assert "There is no port /dev/nosuch" in found.failed().detail.en


def test_a_url_that_makes_no_sense_is_the_caller_s_mistake():
    with pytest.raises(BadPortUrl):
        Examined(url="nosuch://x")


def test_a_busy_computer_that_holds_back_writes_is_no_bad_echo(monkeypatch):
    writes = []

    def write(link: WithChip, data: bytes) -> None:
        writes.append(data)
        if len(writes) % 4 == 0:
            link.link.gather(link.now() + 1.6)
        link.link.write(data)

    monkeypatch.setattr(WithChip, "write", write, raising=False)
    assert Examined("&lost=1").steps["baud"].detail.en == "about 9600 bit/s"


def test_the_baud_rate_is_measured_by_the_echo_also_where_no_ecu_answers():
    found = Examined("&lost=1")
    assert found.names == ["port", "echo", "baud", "ecu"]
    assert found.steps["baud"].detail.en == "about 9600 bit/s"


def test_a_chip_that_made_another_rate_of_the_one_that_was_asked_for_is_named():
    steps = Examined("&baud=14400&lost=1", baud=10400, chip="CP210x").steps
    assert steps["baud"].ok is False
    assert "14400 bit/s instead of 10400: a CP2101, CP2102" in steps["baud"].detail.en
    assert "вместо 10400: CP2101, CP2102" in steps["baud"].detail.ru
    for baud, chip in ((9600, "CP210x"), (10400, "FT232R"), (10400, "")):
        detail = Examined("&baud=14400&lost=1", baud=baud, chip=chip).steps["baud"].detail
        assert "the other end is set to another baud rate" in detail.en


def test_only_a_chip_with_a_latency_timer_is_told_to_lower_it():
    for chip, has_timer in (("FT232R", True), ("", True), ("CP210x", False), ("CH340", False)):
        detail = Examined("&latency_ms=16", chip=chip).steps["latency"].detail
        assert ("latency timer" in detail.en) is has_timer, chip
        assert "hands bytes over in lumps" in detail.en


@pytest.mark.parametrize("milliseconds", [16, 20])
def test_a_latency_timer_is_reported_and_disturbs_no_other_step(milliseconds):
    found = Examined(f"&latency_ms={milliseconds}")
    assert found.steps["latency"].ok is None
    assert "latency timer" in found.steps["latency"].detail.en
    assert found.steps["ecu"].ok is True
    assert found.steps["baud"].ok is True


@pytest.mark.parametrize(
    ("settings", "step"),
    [
        ("&supplied=0", "echo"),
        ("&lost=1", "ecu"),
        ("&latency_ms=20", "latency"),
        ("&bad-echo=1", "echo"),
    ],
)
@pytest.mark.parametrize("kind", PortKind)
def test_each_step_s_advice_fits_the_kind_of_port(settings, step, kind):
    found = Examined(settings, kind=kind).steps[step]
    assert found.ok is not True
    over_network = kind is PortKind.NETWORK
    assert ("bridge" in found.detail.en) == ("мост" in found.detail.ru) == over_network
    assert not (over_network and re.search("USB|FT232|Windows", found.detail.en))


@pytest.mark.parametrize("unknown", ["silent", "01"])
def test_commands_that_the_unit_lacks_are_named(unknown):
    found = Examined(f"&missing=blocks,stream&unknown={unknown}")
    assert found.names == ALL
    tried = found.steps["commands"]
    assert tried.ok is None
    assert "21 read RAM bytes" in tried.detail.en
    assert "71 циклический поток" in tried.detail.ru


@pytest.mark.parametrize("unknown", ["silent", "01"])
@pytest.mark.parametrize("most", [1, 255])
def test_no_single_parameter_decides_whether_reading_and_streams_are_known(unknown, most):
    data = {code: raw for code, raw in DATA.items() if code not in (0x29, 0x2C)}
    ecu = ecu_on(bench(data, unknown=unknown, max_list=most))
    known = {support.command: support.known for support in ecu.supported()}
    assert known[commands.ReadParameters]
    assert known[commands.StreamCyclic] is (most > 1)


def test_a_clean_unit_that_answers_01_to_what_it_does_not_know():
    assert all(step.ok for step in Examined("&unknown=01").steps.values())


@pytest.mark.parametrize("line_fault", ["damaged", "noise", "cut", "bad-echo"])
def test_a_noisy_line_is_reported(line_fault):
    judged = set()
    for seed in range(6):
        found = Examined(f"&{line_fault}=0.3&seed={seed}")
        if "line" in found.steps:
            judged.add(found.steps["line"].ok)
            assert found.steps["line"].ok or "ground" in found.steps["line"].detail.en
    assert False in judged


def test_a_little_noise_is_no_failure():
    judged = [Examined(f"&damaged=0.05&seed={seed}").steps for seed in range(8)]
    lines = [steps["line"] for steps in judged if "line" in steps]
    assert None in {line.ok for line in lines}
    for line in lines:
        if line.ok is None:
            assert "of 20 exchanges failed" in line.detail.en
            assert "из 20" in line.detail.ru


def test_another_baud_rate_than_the_requested_one_is_found():
    """As with a wire at 4800 behind a port that says 9600."""
    steps = Examined("&baud=4800").steps
    assert steps["baud"].ok is False
    assert steps["baud"].detail.en.startswith("about 4800 bit/s instead of 9600")
    assert steps["latency"].ok is True  # measured by the wire's own pace
    assert steps["ecu"].ok is True


def test_a_computer_too_busy_for_short_echoes_makes_no_slow_wire_right(monkeypatch):
    on_time = doctor.Tester.time_echo

    def time_echo(tester, body):
        return on_time(tester, body) + (0.1 if len(body) < 10 else 0.0)

    monkeypatch.setattr(doctor.Tester, "time_echo", time_echo)
    for baud in (4800, 9600):
        step = Examined(f"&baud={baud}").steps["baud"]
        assert step.ok is None
        assert "too busy" in step.detail.en


def test_an_echo_faster_than_a_wire_decides_nothing():
    steps = Examined("&baud=115200").steps
    assert steps["baud"].ok is None
    assert "faster than a wire" in steps["baud"].detail.en


def test_an_adapter_pulled_out_fails_the_step_that_follows():
    links = []

    def opened() -> Link:
        links.append(open_link("sim:?clock=simulated"))
        return links[0]

    steps = []
    for step in examine(opened, ConnectionOptions().create_ecu):
        steps.append(step)
        if step.name == "ecu":
            links[0].unplug()
    assert steps[-1].name == "commands"
    assert steps[-1].ok is False
    assert "is gone" in steps[-1].detail.en
