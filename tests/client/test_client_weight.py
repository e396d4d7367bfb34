"""A client needs pyserial and platformdirs alone: no other package, not even numpy."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.metadata import packages_distributions

import pytest

NEEDED = {"serial", "platformdirs"}

# In front of each program: every other package is refused, as if it were not installed.
REFUSING = """
import sys

class Refusing:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in OTHERS:
            raise ModuleNotFoundError(f"a client imports {name}", name=name)
        return None

OTHERS = set(sys.argv[1].split())
sys.meta_path.insert(0, Refusing())
"""
SESSION = """
import mikas
from mikas.errors import MikasError, NoConnection

SIM = "sim:?clock=simulated"
with mikas.connect(SIM) as ecu:
    print(ecu.read("TWAT")["TWAT"].value, ecu.read("FUEL_FLOW")["FUEL_FLOW"].unit)
    dump = ecu.memory.code.read_block(0x8000, 64)
    print(len(dump), len(ecu.faults()), ecu.info().model.text.en)
    print(sum(1 for _ in ecu.watch("FREQ", count=3)))
with mikas.session(SIM, ["FREQ", "FUEL_FLOW"], count=5, record="drive.pcapng") as session:
    print(sum(1 for _ in session), session.recording.samples >= 5)
try:
    mikas.connect("/dev/there-is-none")
except NoConnection as error:
    print(type(error).__name__)
"""
ASYNCHRONOUS = """
import asyncio
import mikas

async def main():
    async with await mikas.AsyncEcu.connect("sim:?clock=simulated") as ecu:
        print((await ecu.read("TWAT"))["TWAT"].value)
    async with mikas.async_session("sim:?clock=simulated", ["FREQ"], count=2) as session:
        print(len([each async for each in session]))

asyncio.run(main())
"""
READING = """
import mikas
try:
    mikas.open("drive.pcapng")
except ModuleNotFoundError as error:
    print(error.name)
"""


def run(program, tmp_path):
    """Run the program without any package but `NEEDED`; return its output."""
    others = set(packages_distributions()) - NEEDED - sys.stdlib_module_names - {"mikas"}
    assert {"numpy", "click", "rich", "tomlkit", "pydantic"} <= others
    done = subprocess.run(
        [sys.executable, "-c", REFUSING + program, " ".join(others)],
        capture_output=True, text=True, encoding="utf-8", timeout=60, check=False, cwd=tmp_path,
        env=os.environ | {"MIKAS_STATE": str(tmp_path / "state")},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout.split("\n")


@pytest.mark.realtime
@pytest.mark.parametrize(
    ("program", "expected"),
    [
        (SESSION, ["86 l/h", "64 0 Mikas 7.1", "3", "5 True", "PortNotFound", ""]),
        (ASYNCHRONOUS, ["86", "2", ""]),
    ],
    ids=["session", "asyncio"],
)
def test_a_client_reads_dumps_and_records_without_other_packages(tmp_path, program, expected):
    assert run(program, tmp_path) == expected


@pytest.mark.realtime
def test_columns_are_what_needs_numpy(tmp_path):
    run(SESSION, tmp_path)
    reading = (
        'import mikas\ntry:\n    mikas.open("drive.pcapng")\nexcept ModuleNotFoundError as it:'
    )
    assert run(f"{reading}\n    print(it.name)", tmp_path) == ["numpy", ""]
