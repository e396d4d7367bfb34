"""The wheel and the source distribution, installed as people do it, with no Node and no network.

pipx, uv and the packages that mikas needs come from a wheelhouse that was downloaded before.
"""

from __future__ import annotations

import tarfile
import zipfile

import pytest
from tools.package.environment import python, wheelhouse

from installing.computer_rig import Computer, built


@pytest.fixture(scope="module")
def tools():
    """The Python that has pipx and uv."""
    return python()


@pytest.fixture
def computer(tmp_path):
    with Computer(tmp_path / "home", [tmp_path / "home" / ".local" / "bin"]) as computer:
        computer.home.mkdir()
        house = f"{wheelhouse()} {built('*.whl').parent}"
        computer.environment = {
            "PIP_NO_INDEX": 1, "PIP_FIND_LINKS": house, "PIP_CONFIG_FILE": "/dev/null",
            "UV_OFFLINE": 1, "UV_NO_INDEX": 1, "UV_FIND_LINKS": house.replace(" ", ","),
            "UV_NO_CONFIG": 1, "UV_NO_CACHE": 1,
        }  # fmt: skip
        yield computer
        assert not computer.has("node")
        assert not computer.has("npm")


def try_it(computer, program):
    trial = computer.trial(program)
    trial.begins()
    trial.shows_its_page()
    trial.records_and_exports(["csv", "msl", "mlg"])  # the others are extras


def test_both_archives_hold_the_page_and_its_licences():
    with zipfile.ZipFile(built("*.whl")) as wheel, tarfile.open(built("*.tar.gz")) as source:
        page = {name for name in wheel.namelist() if name.startswith("mikas/dashboard/page/")}
        names = {name.rpartition("/")[2] for name in page}
        assert {"index.html", "icon.svg", "licences.txt"} <= names
        assert any(name.endswith(".js") for name in names)
        inside = {name.partition("/src/")[2] for name in source.getnames()}
        assert page <= inside
        licences = wheel.read("mikas/dashboard/page/licences.txt").decode()
    for name in ("svelte", "uplot", "MIT License"):
        assert name.lower() in licences.lower()


def test_the_wheel_brings_the_manual_and_the_scripts_of_shells():
    with zipfile.ZipFile(built("*.whl")) as wheel:
        shared = {name.partition(".data/data/share/")[2] for name in wheel.namelist()}
    for name in (
        "man/man1/mikas.1", "man/man1/mikas-mem-dump.1", "man/ru/man1/mikas-read.1",
        "bash-completion/completions/mikas", "zsh/site-functions/_mikas",
        "fish/vendor_completions.d/mikas.fish",
    ):  # fmt: skip
        assert name in shared


def test_pipx_installs_a_program_that_works_and_removes_it(computer, tools):
    computer.run(tools, "-m", "pipx", "install", "mikas", "--python", tools)
    program = computer.home / ".local" / "bin" / "mikas"
    try_it(computer, program)
    assert program.with_name("mikas-dashboard").exists()
    computer.run(tools, "-m", "pipx", "uninstall", "mikas")
    assert not program.exists()


def test_uv_installs_a_program_that_works_and_removes_it(computer, tools):
    computer.run(tools.with_name("uv"), "tool", "install", "mikas", "--python", tools)
    program = computer.home / ".local" / "bin" / "mikas"
    try_it(computer, program)
    computer.run(tools.with_name("uv"), "tool", "uninstall", "mikas")
    assert not program.exists()


def test_pip_installs_a_program_that_works_from_the_source_distribution(computer, tools):
    environment = computer.home / "environment"
    computer.run(tools, "-m", "venv", environment)
    computer.run(environment / "bin" / "pip", "install", built("mikas-*.tar.gz"))
    try_it(computer, environment / "bin" / "mikas")
