"""A user without a home folder, and without a name: a container. Only root becomes such a user."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys

import pytest

from fleet_rig import make
from mikas.files import beside

STRANGER = (
    "setpriv", "--reuid=54321", "--regid=54321", "--clear-groups",
    "--inh-caps=-all,+dac_read_search", "--ambient-caps=+dac_read_search",
)  # fmt: skip
"""It may read the Python that runs this, wherever that is installed."""
PROGRAM = """
import json, sys
from mikas.cli.main import run
print(json.dumps([run(words) for words in json.load(sys.stdin)]))
"""
SIM = ("--port", "sim:?clock=simulated")


@pytest.mark.skipif(
    (os.geteuid() != 0 or shutil.which("setpriv") is None)
    and not os.environ.get("MIKAS_REQUIRE_ROOT"),
    reason="only root becomes a user without a name (setpriv)",
)
@pytest.mark.parametrize("home", [None, "", "/dev/null", "here"])
def test_commands_work_and_make_no_folder(home, tmp_path):
    """It was “a bug in mikas” for all but two."""
    drive = make(tmp_path / "in.pcapng")
    current = tmp_path / "current"
    current.mkdir()
    for path in (tmp_path, current):
        os.chown(path, 54321, 54321)
    lines = [
        ["ports"], ["params"], ["read", "TWAT", *SIM], ["faults", *SIM], ["info", *SIM],
        ["log", "-o", f"{tmp_path}/log.pcapng", "TWAT", "--count", "2", *SIM],
        ["decode", str(drive)], ["export", str(drive), "-o", f"{tmp_path}/e.csv"],
        ["find", str(drive), "FREQ>0"], ["wireshark"], ["sigrok"], ["test"],
        ["write", "UOZ", "5", "--yes", *SIM], ["wireshark", "--install"],
    ]  # fmt: skip
    given = {} if home is None else {"HOME": home}
    done = subprocess.run(
        [*STRANGER, sys.executable, "-c", PROGRAM],
        input=json.dumps(lines), capture_output=True, text=True, check=True, cwd=current,
        env={"PATH": os.environ["PATH"], "LANG": "C.UTF-8", **given},
    )  # fmt: skip
    assert json.loads(done.stdout.splitlines()[-1]) == [0] * 12 + [2, 2]  # no journal, no place
    assert "left out" not in done.stderr
    assert list(current.iterdir()) == []


def test_a_name_at_the_limit_of_the_system_gets_a_second_one(tmp_path):
    """`NAME.part` was refused by the system, though NAME was not."""
    paths = [tmp_path / f"{'ж' * 123}{end}.csv" for end in "ab"]
    seconds = [beside(path, ".part") for path in paths]
    for path in (*paths, *seconds):
        path.write_text("", "utf-8")
    assert len(set(seconds)) == 2
    assert all(second.name.endswith(".part") for second in seconds)
    assert beside(tmp_path / "short", ".part").name == "short.part"
