"""Every example runs as it stands, against the virtual car on simulated time."""

from __future__ import annotations

import os
import runpy
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import mikas
from mikas.client import MemorySpace
from mikas.link import urls

EXAMPLES = Path(__file__).parents[1] / "examples"
EXPECTED = {
    "read_values.py": "TWAT         86 °C   bytes 7e",
    "log_and_plot.py": "360 samples in drive.csv",
    "erase_faults.py": "stored now: []",
    "dump_memory.py": "4096 bytes in code-8000.bin",
    "two_units.py": "sim:?clock=simulated&scenario=city: 840 rpm",
    "stream_to_pandas.py": "method: stream",
    "join_gps.py": "7.4 l/100 km over 0.54 km",
    "codec_bytes.py": "at byte 7: TWAT 86 °C",
    "write_parameter.py": "before: UOZ 13.5 ° crank now: UOZ 12.5 ° crank",
    "own_catalog/read_own.py": "TWAT 86 °C danger above 105\nLOAD 3.86 %",
}
LINK = "own_link/mikas_trace.py"  # a package, which is installed
EXPORT = "own_export/mikas_jsonlines.py"  # as well; tests/recording/export/test_own_formats.py
TESTS = ("test_overheating.py", "socket_link/test_socket_link.py")  # pytest runs them
MODULES = ("socket_link/socket_link.py",)
ALL = (*EXPECTED, LINK, EXPORT, *TESTS, *MODULES)


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    """Run an example in an empty folder; returns its output."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("builtins.input", lambda _: "y")

    def run(name):
        monkeypatch.setattr(sys, "argv", [name])
        runpy.run_path(str(EXAMPLES / name), run_name="__main__")
        return capsys.readouterr().out

    return run


def test_every_example_is_run():
    scripts = {path.relative_to(EXAMPLES).as_posix() for path in EXAMPLES.rglob("*.py")}
    assert scripts == {*ALL}


@pytest.mark.parametrize("name", EXPECTED)
def test_each_example_prints_what_is_expected(run, name):
    assert EXPECTED[name] in run(name)


@pytest.mark.parametrize("name", ALL)
def test_each_example_has_10_to_80_lines(name):
    longest = 80 if name in TESTS or name in MODULES else 50
    assert 10 <= len((EXAMPLES / name).read_text("utf-8").splitlines()) <= longest


@pytest.mark.parametrize("name", ALL)
def test_the_guide_names_each_example(name):
    guide = (EXAMPLES / "README.md").read_text("utf-8")
    assert f"]({name})" in guide or f"]({Path(name).parent}/)" in guide


def test_what_was_logged_is_drawn(run, tmp_path):
    run("log_and_plot.py")
    header, *rows = (tmp_path / "drive.csv").read_text("utf-8").splitlines()
    assert header == "time,FREQ,TWAT"
    assert len(rows) == 360
    assert (tmp_path / "drive.svg").read_text("utf-8").count("<polyline") == 2


def test_what_is_not_confirmed_is_not_erased(run, monkeypatch):
    monkeypatch.setattr("builtins.input", lambda _: "")
    assert "nothing was changed" in run("erase_faults.py")


@pytest.mark.parametrize("name", TESTS)
def test_the_tests_of_an_example_pass(name, tmp_path):
    options = ["-q", "-W", "error", "-p", "no:cacheprovider", "-p", "mikas.testing.plugin"]
    done = subprocess.run(
        [sys.executable, "-m", "pytest", *options, "--rootdir", str(tmp_path), "-c", os.devnull,
         str(EXAMPLES / name)],
        capture_output=True, text=True, cwd=tmp_path, check=False,
        env={**os.environ, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"},
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr


def test_a_cancelled_dump_leaves_the_line_in_step(run, monkeypatch):
    blocks = MemorySpace.blocks

    def interrupted(*args):
        for number, block in enumerate(blocks(*args)):
            if number == 3:
                raise KeyboardInterrupt
            yield block

    monkeypatch.setattr(MemorySpace, "blocks", interrupted)
    printed = run("dump_memory.py")
    assert "cancelled at 82FD" in printed
    assert "765 bytes in code-8000.bin; the line is in step: UACC 14.1 V" in printed


def test_a_change_that_is_not_confirmed_is_not_written(run, monkeypatch):
    monkeypatch.setattr("builtins.input", lambda _: "no")
    printed = run("write_parameter.py")
    assert "UOZ: 13.5 ° crank → 12.5 ° crank" in printed
    assert "nothing was changed" in printed


@pytest.fixture
def installed_link(tmp_path, monkeypatch):
    """The package of the example, as `pip install` would register it."""
    project = tomllib.loads((EXAMPLES / "own_link/pyproject.toml").read_text("utf-8"))["project"]
    metadata = tmp_path / "mikas_trace-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text(f"Name: {project['name']}\nVersion: {project['version']}\n")
    entries = project["entry-points"]["mikas.links"].items()
    lines = ["[mikas.links]", *(f"{name} = {place}" for name, place in entries)]
    (metadata / "entry_points.txt").write_text("\n".join(lines))
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.syspath_prepend(EXAMPLES / "own_link")
    urls.registered.cache_clear()
    yield
    urls.registered.cache_clear()
    sys.modules.pop("mikas_trace", None)


@pytest.mark.usefixtures("installed_link")
def test_a_link_of_another_package_is_found_by_its_scheme(capsys, tmp_path):
    with mikas.connect("trace:sim:?clock=simulated", state=tmp_path / "units") as ecu:
        assert ecu.read("TWAT")["TWAT"].value == 86
    printed = capsys.readouterr().err
    assert " > 61 1a 85 0d\n" in printed
    assert " < 7e\n" in printed  # 126 − 40 °C
