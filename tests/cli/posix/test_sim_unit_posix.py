"""`mikas sim --unit` as it is run: a process, a real pty, and a tester on it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import zipfile

import pytest

import mikas
from mikas.virtual.unit_profile import CodeProfile, UnitProfile

pytestmark = pytest.mark.realtime

PROFILE = UnitProfile(
    version_code=0x2C,
    echo=False,
    turn_round=0.012,
    max_list_61=2,
    unknown="01",
    codes={0x1A: CodeProfile(1), 0x29: CodeProfile(1), 0x90: CodeProfile(2, (b"\x01\x02",))},
    passports=("ОСОБЫЙ", *[""] * 7),
    faults=(53, 13),
)


@pytest.fixture
def port(tmp_path):
    with zipfile.ZipFile(tmp_path / "survey.zip", "w") as archive:
        archive.writestr("unit.json", json.dumps(PROFILE.to_json()))
    command = "from mikas.cli.main import main; main()"
    with subprocess.Popen(
        [sys.executable, "-c", command, "sim", "--unit", "survey.zip"],
        cwd=tmp_path,
        env=os.environ | {"HOME": str(tmp_path), "LANG": "C.UTF-8"},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    ) as process:
        yield process.stdout.readline().strip()
        process.terminate()


def test_a_tester_on_the_pty_meets_the_unit(port):
    with mikas.connect(port) as ecu:
        info = ecu.info()
        assert (info.version_code, info.echo) == (0x2C, False)
        assert info.passport.program[0] == "ОСОБЫЙ"
        assert [fault.code for fault in ecu.faults()] == [53, 13]
        (reading,) = ecu.read("0x90:2").values()
        assert reading.raw == b"\x01\x02"
        assert 600 < ecu.read("FREQ")["FREQ"].value < 1300  # the engine of the model idles
        with ecu.stream("FREQ", "TWAT") as responses:
            assert len([next(responses) for _ in range(5)]) == 5
