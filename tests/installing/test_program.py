"""The one-folder program, unpacked in another folder and started with nothing around it."""

from __future__ import annotations

import json
import os
import plistlib
import subprocess
import tarfile
import zipfile
from configparser import ConfigParser

import pytest
from tools.package.trial import Trial, Wrong

import mikas
from installing.computer_rig import Computer, built


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Where the archive was unpacked; its name has a space and a letter of another alphabet."""
    to = tmp_path_factory.mktemp("program") / "my програма"
    to.mkdir()
    with tarfile.open(built("mikas-*-linux-*.tar.xz")) as archive:
        archive.extractall(to, filter="data")
    return to / "mikas"


@pytest.fixture
def computer(tmp_path):
    with Computer(tmp_path) as computer:
        assert not computer.has("python3")
        yield computer


def test_it_works_with_nothing_around_it(folder, computer):
    computer.trial(folder / "mikas").everything()
    table = mikas.open(computer.home / "drive.pcapng").to_pandas()
    assert len(table) == len((computer.home / "drive.csv").read_text("utf-8").splitlines()) - 1


def test_every_file_of_the_wheel_is_inside(folder):
    with zipfile.ZipFile(built("*.whl")) as wheel:
        names = {name for name in wheel.namelist() if not name.endswith("/RECORD")}
        names = {name for name in names if ".data/" not in name}  # for man and shells
        packages = {name.rpartition("/")[0] for name in names if name.endswith("/__init__.py")}
        modules = {n for n in names if n.endswith(".py") and n.rpartition("/")[0] in packages}
        data = names - modules
        assert any(name.endswith(".py") for name in data)  # sigrok's, which are read
        for name in data:
            assert (folder / "_internal" / name).is_file(), name
            assert (folder / "_internal" / name).read_bytes() == wheel.read(name), name
    assert len(data) > 30


def test_every_link_of_the_wheel_is_known(folder, computer):
    entries = ConfigParser()
    with zipfile.ZipFile(built("*.whl")) as wheel:
        (name,) = [each for each in wheel.namelist() if each.endswith("/entry_points.txt")]
        entries.read_string(wheel.read(name).decode())
    tape = computer.home / "a.pcapng"
    ask = (folder / "mikas", "read", "TWAT", "--json", "--port")
    computer.run(*ask, "sim:?clock=simulated", "--capture", tape)
    addresses = {"sim": "sim:?clock=simulated", "replay": f"replay:{tape}?clock=simulated",
                 "serial": "serial:///dev/nosuch", "socket": "socket://127.0.0.1:9",
                 "rfc2217": "rfc2217://127.0.0.1:9"}  # fmt: skip
    for scheme in entries["mikas.links"]:
        answer = json.loads(
            subprocess.run(
                computer.command(*ask, addresses[scheme]),
                capture_output=True,
                encoding="utf-8",
                check=False,
            ).stdout
        )
        # No such port, or nothing behind it: the link itself was loaded.
        code = answer.get("error", {}).get("code")
        assert code in (None, "PortNotFound", "PortFailed", "LinkLost", "RecordingOver"), answer


def test_the_browser_gets_the_systems_libraries(folder, tmp_path):
    """PyInstaller's start sets LD_LIBRARY_PATH, with which no browser starts."""
    with Computer(tmp_path, ["/usr/bin", "/bin"]) as computer:
        browser, seen = tmp_path / "browser", tmp_path / "seen"
        os.mkfifo(seen)
        browser.write_text(f'#!/bin/sh\nenv > "{seen}"\n')
        browser.chmod(0o755)
        (tmp_path / "config.toml").write_text("prot = 1\n")
        computer.environment = {
            "BROWSER": f"{browser} %s",
            "MIKAS_CONFIG": tmp_path / "config.toml",
            "LD_LIBRARY_PATH": "/my/own",
        }
        process = subprocess.Popen(
            computer.command(folder / "mikas", "dash", "--desktop"), stderr=subprocess.PIPE
        )
        try:
            assert b"config.toml" in process.stderr.readline()
            variables = seen.read_text()
        finally:
            process.kill()
            process.communicate()
        assert "LD_LIBRARY_PATH=/my/own\n" in variables


def test_the_trial_knows_what_a_double_click_on_macos_starts(tmp_path):
    """PyInstaller takes the first program by name, `mikas`, which shows its help and ends."""
    contents = tmp_path / "mikas.app" / "Contents"
    (contents / "MacOS").mkdir(parents=True)
    trial = Trial(contents / "MacOS" / "mikas", tmp_path)
    for name in ("mikas", "mikas-dashboard"):
        (contents / "MacOS" / name).touch()
        (contents / "Info.plist").write_bytes(plistlib.dumps({"CFBundleExecutable": name}))
        if name == "mikas":
            with pytest.raises(Wrong, match="a double click starts mikas"):
                trial.is_an_application()
    trial.is_an_application()


def test_the_notices_have_the_licence_of_each_part(folder):
    text = (folder / "_internal" / "notices.txt").read_text("utf-8")
    inside = {each.name.split("-")[0] for each in (folder / "_internal").glob("*.dist-info")}
    for name in {*inside, "asammdf", "duckdb", "numpy", "pandas", "lxml", "pyserial", "Python"}:
        assert f"\n{name.lower().replace('_', '-')} " in text.lower().replace("_", "-"), name
    assert "GNU LESSER GENERAL PUBLIC LICENSE" in text  # asammdf's
    assert "PyInstaller" in text
    libraries = {each.name for each in (folder / "_internal").glob("lib*.so*")}
    assert not {each for each in libraries if "readline" in each}  # it would make all of it GPL
