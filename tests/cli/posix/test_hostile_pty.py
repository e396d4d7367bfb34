"""A real terminal and a hostile unit, catalog and recording: only this program's own sequences."""

from __future__ import annotations

import os
import pty
import re
import subprocess
import sys

import pytest
from test_hostile_terminal import ESC, LINES, made  # noqa: F401  (a fixture)
from test_terminal import steering

pytestmark = pytest.mark.realtime

# Of rich and of the redrawn line: colours, cursor, screen. No OSC, no C1.
OWN = re.compile(r"\x1b\[[\d;]*[ABHKm]|\x1b\[\?(?:25|1049)[hl]|\r")
PROGRAM = """
import sys
from mikas.cli.main import run
lines = eval(sys.argv[1])
for line in lines:
    run(list(line))
"""
SHOWN = ("info", "params", "read", "faults", "watch", "log", "mem", "decode", "report", "scan")


def test_a_terminal_gets_no_sequence_of_a_stranger(made, tmp_path):  # noqa: F811
    lines = [line for line in LINES if line[0] in SHOWN and "-vv" not in line and ESC not in line]
    lines.append(("read", "EVIL", "-vv"))
    environment = os.environ | {
        "TERM": "xterm-256color", "HOME": str(tmp_path), "XDG_CONFIG_HOME": str(tmp_path),
        "MIKAS_PORT": "sim:?clock=simulated&scenario=evil.toml", "LANG": "C.UTF-8",
        "MIKAS_CONFIG": str(tmp_path / "config.toml"), "COLUMNS": "200",
    }  # fmt: skip
    (tmp_path / "config.toml").write_text(f'catalog = ["{made / "own.toml"}"]\n', "utf-8")
    master, slave = pty.openpty()
    command = [sys.executable, "-c", PROGRAM, repr(lines)]
    with subprocess.Popen(
        command, cwd=made, env=environment, stdin=subprocess.DEVNULL, stdout=slave, stderr=slave
    ) as process:
        os.close(slave)
        shown = b""
        try:
            while piece := os.read(master, 1 << 16):
                shown += piece
        except OSError:  # Linux: the other end is closed
            pass
        finally:
            os.close(master)
    assert process.returncode == 0, shown
    text = shown.decode("utf-8")
    assert "\x1b[" in text  # rich has drawn
    assert r"\x1b]52;c" in text
    assert "\u241b]52;c" in text
    assert not steering(OWN.sub("", text))
    assert "\x1b[2J" not in text  # a catalog's, not ours
