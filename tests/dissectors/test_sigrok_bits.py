"""The virtual unit's wire as logic levels, read back by the real sigrok-cli.

It is an independent witness: its UART finds the bytes in the bits, so a wrong level, bit order or
time of the virtual wire would show. Skipped where there is no sigrok-cli, unless
`MIKAS_REQUIRE_SIGROK` is set: then that is a failure.
"""

from __future__ import annotations

import json
import os
import shutil
from contextlib import suppress
from functools import cached_property
from random import Random

import pytest

from dissectors.levels_rig import BITS, FORMATS, Tap, signals
from dissectors.sigrok_rig import installed, sigrok_cli
from mikas import commands as c
from mikas.cli.main import run as mikas
from mikas.client.connecting import ConnectionOptions
from mikas.client.parameters.polling import FIXED_METHODS as METHODS
from mikas.errors import MikasError
from mikas.framing import encode
from mikas.link import CaptureTee, open_link
from mikas.recording.capture.writer import CaptureWriter
from mikas.virtual.fault_injector import LineFault
from tester.tester_rig import case

pytestmark = pytest.mark.skipif(
    shutil.which("sigrok-cli") is None and not os.environ.get("MIKAS_REQUIRE_SIGROK"),
    reason="sigrok-cli is not installed",
)

BODIES = [
    "1140", "12400D", "13400D", "140D4077", "150080", "16008012", "214005", "22400301020D",
    "23001003", "24001002400D", "25008004", "2600800101", "3190", "32900D", "6155", "99", "62290D",
    "620E08", "620E00", "6100", "410080",
]  # fmt: skip
FASTEST = ("TWAT", "FREQ", "INJ", "RXX")
KINDS = ("request", "response")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return installed(tmp_path_factory.mktemp("decoders"))


class Drive:
    """All commands and methods with one virtual unit: its wire, and what `mikas decode` says."""

    def __init__(self, folder, settings):
        link = self.link = open_link(f"sim:?clock=simulated&faults=13,64,21&{settings}")
        self.tap = Tap(link.bus)
        self.capture = folder / "drive.pcapng"
        with CaptureWriter(self.capture, url="sim:") as writer:
            options = ConnectionOptions(
                confirm=lambda change: True, journal=folder / "journal", state=folder
            )
            ecu = options.create_ecu(CaptureTee(link, writer))
            ecu.tester.connect()
            self.drive(ecu)

    def drive(self, ecu):
        ecu.read()
        ecu.faults()
        ecu.passport()
        ecu.tester.request(c.CountParameters())
        for body in BODIES:
            with suppress(MikasError):
                ecu.raw(bytes.fromhex(body))
        for method in METHODS:
            assert len(list(ecu.watch(*FASTEST, method=method, count=3))) == 3
        ecu.set_list("UACC", "JQT")
        ecu.read_list()

    @cached_property
    def lines(self):
        """Return the lines of `mikas decode --json`."""
        out = self.capture.with_suffix(".json")
        with out.open("w", encoding="utf-8") as file, pytest.MonkeyPatch.context() as patch:
            patch.setattr("sys.stdout", file)
            assert mikas(["decode", "--json", str(self.capture)]) == 0
        return [json.loads(line) for line in out.read_text("utf-8").splitlines()]

    @cached_property
    def decoded(self):
        """Return the frames without echoes, of a line without damage."""
        found = [line for line in self.lines if not line["echo"]]
        assert not [line for line in found if line["type"] != "frame"]
        return found


@pytest.fixture(scope="module", params=["5.4", "7.1"])
def drive(request, tmp_path_factory):
    return Drive(tmp_path_factory.mktemp("drive"), f"model={request.param}")


def said(annotations, *kinds):
    return sorted((each for each in annotations if each.kind in kinds), key=lambda each: each.ss)


def check_all(drive, annotations):
    """Assert that the decoder says of every frame what `mikas decode` does."""
    lines = drive.decoded
    frames = said(annotations, "frame")
    assert [each.text.replace(" ", "") for each in frames] == [line["wire"] for line in lines]
    roles = said(annotations, *KINDS, "unclear")
    assert len(roles) == len(lines)
    for line, role in zip(lines, roles, strict=True):
        if line["body"] == "99":  # no command: on one wire it may be either
            assert role.kind == "unclear"
        else:
            assert role.kind == {"sent": "request", "received": "response"}[line["direction"]]
            assert line["meaning"] is None or role.text == line["meaning"]["en"]
    assert not said(annotations, "damage")


def values_in(line):
    """Return the texts of the values in a line of `mikas decode`."""
    meaning = line["meaning"]["en"]
    return meaning.split(" ") if "=" in meaning else []


def shown_values(annotations):
    return [each.text.rsplit(": ", 1)[-1] for each in said(annotations, "value", "flag")]


@pytest.mark.parametrize(
    ("rate", "form", "baud_error"),
    [
        (50_000, "bin", 0.0),
        (115_200, "sr", -0.02),
        (1_000_000, "vcd", 0.02),
    ],
)
def test_every_command_and_method_is_read_back_from_the_bits(
    drive, folder, tmp_path, rate, form, baud_error
):
    made = signals(drive.tap, rate, baud_error=baud_error)
    arguments = FORMATS[form](tmp_path / f"line.{form}", made)
    name = {"bin": "0", "sr": "K-Line", "vcd": "D0"}[form]
    annotations = sigrok_cli(folder, arguments, channels=f"rx={name}")
    check_all(drive, annotations)
    lines = [line for line in drive.decoded if line["direction"] == "received"]
    expected = [text for line in lines if line["meaning"] for text in values_in(line)]
    assert " ".join(shown_values(annotations)) == " ".join(expected)


def test_two_channels_of_an_adapter_need_no_guess(drive, folder, tmp_path):
    for echo in (True, False):
        made = signals(drive.tap, 100_000, wires=2, echo=echo)
        arguments = FORMATS["bin"](tmp_path / "line.bin", made)
        annotations = sigrok_cli(folder, arguments, channels="rx=0:tx=1")
        with case(f"echo {echo}"):
            lines = drive.decoded
            roles = said(annotations, *KINDS)
            assert [each.kind == "request" for each in roles] == [
                line["direction"] == "sent" for line in lines
            ]
            for line, role in zip(lines, roles, strict=True):
                assert line["meaning"] is None or role.text == line["meaning"]["en"]
            sent = sum(line["direction"] == "sent" for line in lines)
            assert len(said(annotations, "echo")) == (sent if echo else 0)
            assert not said(annotations, "damage", "unclear")


class CalmDrive(Drive):
    """Reads by 61 and 63 and a stream, with pauses in which the line is quiet."""

    def drive(self, ecu):
        link = ecu.tester.link
        for _ in range(12):
            ecu.read("TWAT", "INJ", "RXX", "JQT")
            link.gather(link.now() + 0.003)
        ecu.set_list(*FASTEST)
        for _ in range(12):
            link.gather(link.now() + 0.003)
            ecu.read_list()
        assert len(list(ecu.watch(*FASTEST, method="stream", count=20))) == 20

    def frames(self):
        """Return (time of its first bit, line of `mikas decode`) of each frame."""
        merged = sorted(self.tap.sent + self.tap.received)
        found, at = [], 0
        for line in self.decoded:
            wire = bytes.fromhex(line["wire"])
            assert bytes(value for _, value in merged[at : at + len(wire)]) == wire
            found.append((merged[at][0], line))
            at += len(wire)
        assert at == len(merged)
        return found


@pytest.fixture(scope="module")
def calm(tmp_path_factory):
    return CalmDrive(tmp_path_factory.mktemp("calm"), "seed=5")


def spoil(line, calm, random):
    """Damage about every sixth frame by a bit, and put short and long glitches in between.

    Return the numbers of the frames that may be lost: also one that follows a damaged one at less
    than a byte's distance, because a UART that has lost a start bit needs that to find the next.
    """
    bit, damaged, end = calm.tap.bit, set(), 0.0
    for number, (start, frame) in enumerate(calm.frames()):
        length = len(frame["wire"]) // 2
        pause, end = start - end, start + length * BITS * bit
        if random.random() < 1 / 6:
            at = start + random.randrange(length * BITS) * bit  # also start and stop bits
            line.invert(at, at + bit * random.choice([1, 1, 1, 3]))
            damaged.add(number)
        elif number - 1 in damaged and pause < BITS * bit:
            damaged.add(number)
        elif pause > 15 * bit and random.random() < 1 / 3:
            at = start - 14 * bit
            line.invert(at, at + bit * random.choice([0.2, 0.8]))  # the latter is a byte FF
    return damaged


@pytest.mark.parametrize("rate", [50_000, 115_200, 1_000_000])
def test_noise_and_framing_errors_cost_frames_and_invent_nothing(calm, folder, tmp_path, rate):
    truth = calm.frames()
    for seed in range(4):
        (line,) = made = signals(calm.tap, rate)
        damaged = spoil(line, calm, Random(seed))
        arguments = FORMATS["bin"](tmp_path / "line.bin", made)
        annotations = sigrok_cli(folder, arguments)
        near = rate * calm.tap.bit * 1.5
        with case(f"seed {seed}"):
            assert 5 < len(damaged) < len(truth) / 2
            assert said(annotations, "damage", "warning")
            places = [(time - line.begin) * rate for time, _ in truth]
            shown = said(annotations, "frame")
            for number, (place, (_, frame)) in enumerate(zip(places, truth, strict=True)):
                same = [each for each in shown if abs(each.ss - place) < near]
                if number not in damaged:
                    assert [each.text.replace(" ", "") for each in same] == [frame["wire"]]
            meant = [
                (place, line["meaning"]["en"])
                for place, (_, line) in zip(places, truth, strict=True)
            ]
            roles = said(annotations, *KINDS)
            for role in (each for each in roles if "not known" not in each.text):
                assert [text for at, text in meant if abs(role.ss - at) < near] == [role.text]
            for value in said(annotations, "value", "flag"):
                (role,) = (each for each in roles if each.ss <= value.ss < each.es)
                assert value.text.rsplit(": ", 1)[-1] in role.text
            assert len(roles) > len(truth) / 2


class TroubledDrive(Drive):
    """Reads in three ways on a line with faults, which the tester reports as it may."""

    def __init__(self, folder, seed, faults):
        self.faults = {LineFault(name): 0.15 for name in faults}
        super().__init__(folder, f"seed={seed}")

    def drive(self, ecu):
        link = ecu.tester.link
        self.link.bus.fault_injector.rates = self.faults
        for _ in range(8):
            for names in (("TWAT", "INJ"), ("THR",)):
                with suppress(MikasError):
                    ecu.read(*names)
                link.gather(link.now() + 0.003)
        for method in ("list", "stream"):
            with suppress(MikasError):
                list(ecu.watch("FREQ", "INJ", method=method, count=15))

    def meanings(self):
        """Return what `mikas decode` says: the begin on the wire, the bytes, role and meaning."""
        byte, found = self.tap.bit * BITS, []
        for line in self.lines:
            if line["type"] == "frame" and not line["echo"]:
                received = line["direction"] == "received"
                begin = line["end"] - byte * len(line["wire"]) / 2 if received else line["time"]
                meaning = line["meaning"] and line["meaning"]["en"]
                found.append((begin, line["wire"], KINDS[received], meaning))
        return found


@pytest.mark.parametrize(
    "faults",
    [("late",), ("cut", "lost"), ("doubled", "noise"), ("damaged", "missing-byte")],
)
def test_a_line_in_trouble_gets_no_other_meaning_than_from_mikas_decode(folder, tmp_path, faults):
    for seed in (1, 11):
        (tmp_path / str(seed)).mkdir()
        drive = TroubledDrive(tmp_path / str(seed), seed, faults)
        (line,) = made = signals(drive.tap, 50_000)
        annotations = sigrok_cli(folder, FORMATS["bin"](tmp_path / "line.bin", made))
        wires = {each.ss: each.text.replace(" ", "") for each in said(annotations, "frame")}
        meanings, checked = drive.meanings(), 0
        for role in said(annotations, *KINDS):
            begin = line.begin + role.ss / line.rate
            same = [
                (kind, meaning)
                for at, wire, kind, meaning in meanings
                if abs(at - begin) < 0.003 and wire == wires[role.ss]
            ]
            for kind, meaning in same[:1]:
                with case(f"seed {seed}", f"at {begin:.3f}"):
                    assert role.kind == kind
                    assert meaning in (None, role.text) or "not known" in role.text
                checked += 1
        assert checked > len(meanings) * 0.6


def test_a_break_ends_a_stream_and_is_no_byte(folder, tmp_path):
    link = open_link("sim:?clock=simulated")
    tap = Tap(link.bus)
    link.write(encode(bytes.fromhex("71291A")))
    link.gather(0.05)
    link.send_break(0.025)
    link.gather(link.now() + 0.01)
    for _ in range(2):
        link.write(encode(b"\x01"))
        link.gather(link.now() + 0.05)
    link.bus.collect_received(link.now())
    arguments = FORMATS["bin"](tmp_path / "line.bin", signals(tap, 50_000))
    annotations = sigrok_cli(folder, arguments)
    assert [each.text for each in said(annotations, "damage")][-1] == "line break"
    assert [each.text for each in said(annotations, *KINDS)][-4:] == [
        "availability, model", "Mikas 7.1", "availability, model", "Mikas 7.1",
    ]  # fmt: skip
