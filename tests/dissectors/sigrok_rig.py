"""The sigrok decoder on a bench: in this process over bytes, and in the real sigrok-cli.

`SimulatedSigrok` calls the decoder as libsigrokdecode does, behind a UART that is always right.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from dataclasses import dataclass
from types import ModuleType
from unittest.mock import patch

from mikas.catalog import shipped
from mikas.dissectors.installing import decoder_file, install
from mikas.dissectors.sigrok.generator import MARK, source

ANNOTATIONS, PYTHON, BINARY = range(3)
RATE = 1_000_000
BYTE = 1042  # samples
LINE = re.compile(r'(\d+)-(\d+) mikas-1: ([a-z]+): "(.*)"')


def loaded(text=None, name="mikas_for_sigrok"):
    """Return the decoder's module, its `sigrokdecode` being a stand-in."""
    stand_in = ModuleType("sigrokdecode")
    stand_in.OUTPUT_ANN, stand_in.OUTPUT_PYTHON, stand_in.OUTPUT_BINARY = range(3)
    stand_in.SRD_CONF_SAMPLERATE = 10000
    stand_in.Decoder = type("Decoder", (), {})
    module = ModuleType(name)
    with patch.dict(sys.modules, {"sigrokdecode": stand_in}):
        exec(compile(source(shipped()) if text is None else text, name, "exec"), vars(module))
    module.srd = stand_in
    return module


@dataclass(frozen=True)
class Annotation:
    ss: int
    es: int
    kind: str
    text: str


class SimulatedSigrok:
    """One run of the decoder over bytes."""

    def __init__(self, module, **options):
        self.annotations, self.python, self.binary = [], [], []
        decoder = self.decoder = module.Decoder()
        decoder.options = {each["id"]: each["default"] for each in decoder.options} | options
        decoder.register = lambda kind: kind
        decoder.put = self._put
        decoder.start()
        decoder.metadata(module.srd.SRD_CONF_SAMPLERATE, RATE)
        self.at = 0

    def _put(self, ss, es, kind, data):
        assert ss <= es
        if kind == ANNOTATIONS:
            row, texts = data
            assert all(isinstance(text, str) for text in texts), data
            named = self.decoder.annotations[row][0]
            self.annotations.append(Annotation(ss, es, named, texts[0]))
        elif kind == PYTHON:
            self.python.append((ss, es, data))
        else:
            self.binary.append((self.decoder.binary[data[0]][0], data[1]))

    def wait(self, seconds):
        self.at += round(seconds * RATE)

    def feed(self, data, *, channel=0, sound=True, at=None):
        """Put bytes on the wire, one behind the other."""
        at = self.at if at is None else at
        for value in data:
            self.decoder.decode(at, at, ["STARTBIT", channel, 0])
            self.decoder.decode(at, at + BYTE, ["FRAME", channel, (value, sound)])
            at += BYTE
        self.at = max(self.at, at)

    def send_break(self, seconds=0.025):
        ss = self.at
        self.feed(b"\0", sound=False)
        self.at = ss + round(seconds * RATE)
        self.decoder.decode(ss, self.at, ["BREAK", 0, 0])

    def of(self, *kinds):
        return [each for each in self.annotations if each.kind in kinds]

    def texts(self, *kinds):
        return [each.text for each in self.of(*kinds)]


def sigrok_cli(folder, arguments, *, channels="rx=0", options=""):
    """Return the annotations that the real program prints for a file."""
    decoders = f"uart:baudrate=9600:{channels},mikas{options}"
    printed = run(
        folder,
        [*arguments, "-P", decoders, "-A", "mikas", "--protocol-decoder-samplenum", "-l", "4"],
    ).decode()
    found = [match for line in printed.splitlines() if (match := LINE.fullmatch(line))]
    assert found, printed
    return [Annotation(int(it[1]), int(it[2]), it[3], it[4].split('" "')[0]) for it in found]


def run(folder, arguments):
    """Run sigrok-cli with the decoders of `folder`, and return what it prints."""
    environment = os.environ | {"SIGROKDECODE_DIR": str(folder), "PYTHONDONTWRITEBYTECODE": "1"}
    environment.pop("PYTHONPATH", None)
    result = subprocess.run(
        ["sigrok-cli", *arguments], capture_output=True, env=environment, check=False
    )
    assert result.returncode == 0, result.stderr.decode()
    assert b"Traceback" not in result.stderr, result.stderr.decode()
    return result.stdout


def installed(folder, **options):
    """Install the decoder into a folder of decoders, and return that."""
    install(decoder_file(folder), source(shipped(), **options), MARK)
    return folder
