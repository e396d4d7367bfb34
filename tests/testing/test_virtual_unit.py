"""`VirtualUnit` and the pytest plugin, as a program's own tests would use them."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

import mikas.testing
from mikas.errors import LineError, LinkLost, NoConnection, NotSupported, UsageError
from mikas.testing.units import LineFault, VirtualUnit


@pytest.fixture
def unit():
    with VirtualUnit() as made:
        yield made


def test_values_are_set_and_let_go(unit):
    with unit.connect() as ecu:
        driven = ecu.read("TWAT")["TWAT"].value
        unit.set("TWAT", 110)
        assert ecu.read("TWAT")["TWAT"].value == 110
        for flag in (True, False):
            unit.set("DET", flag)
            assert ecu.read("DET")["DET"].value is flag
        unit.unset("TWAT")
        assert ecu.read("TWAT")["TWAT"].value == pytest.approx(driven, abs=2)
        ecu.write_parameter("UOZ", 12.5)
        unit.set("UOZ", 10)
        assert ecu.read("UOZ")["UOZ"].value == 10
        assert ecu.write_parameter("UOZ", 11).after.value == 11


def test_faults_are_stored_and_erased(unit):
    with unit.connect() as ecu:
        unit.faults = [17]
        unit.faults.append(81)
        assert [fault.code for fault in ecu.faults()] == [17, 81]
        ecu.erase_faults()
        assert unit.faults == []


def test_the_line_fails_as_it_was_said(unit):
    with unit.connect(retries=0) as ecu:
        ecu.read("TWAT")
        unit.next_responses(None, LineFault.DAMAGED)
        ecu.read("TWAT")
        with pytest.raises(LineError):
            ecu.read("TWAT")
        assert ecu.read("TWAT")
    with unit.connect() as ecu:
        unit.next_responses(LineFault.LOST)
        assert ecu.read("TWAT")  # repeated


def test_time_passes_without_a_request(unit):
    with unit.connect() as ecu:
        before = unit.now
        unit.pass_time(600)
        assert unit.now == before + 600
        assert unit.requests == ()
        assert ecu.read("TWAT")
        assert unit.now < before + 601
        assert unit.requests[0][:1] == b"\x61"
    with pytest.raises(UsageError):
        unit.pass_time(-1)


def test_time_passes_also_without_a_connection(unit):
    with unit.connect() as ecu:
        ecu.read("TWAT")
        unit.unplug()
        before = unit.now
        unit.pass_time(60)
        assert unit.now == before + 60
    unit.pass_time(60)
    with unit.connect() as ecu:
        assert ecu.read("TWAT")["TWAT"].time > before + 120


def test_a_cable_is_pulled_out_and_plugged_in(unit):
    with unit.connect() as ecu:
        unit.unplug()
        with pytest.raises(LinkLost, match="unplugged"):
            ecu.read("TWAT")
    at = unit.now
    with unit.connect() as ecu:
        assert ecu.read("TWAT")["TWAT"].time > at


def test_the_key_is_turned(unit):
    with unit.connect() as ecu:
        ecu.set_list("TWAT")
        unit.turn_key(on=False)
        with pytest.raises(NoConnection):
            ecu.read("TWAT")
        unit.turn_key(on=True)
        assert ecu.read("TWAT")
        with pytest.raises(NotSupported):
            ecu.read_list()


def test_options_are_those_of_sim():
    with VirtualUnit(model="5.4", faults="17", latency_ms=16) as unit, unit.connect() as ecu:
        assert ecu.version_code == 0x09
        assert [fault.code for fault in ecu.faults()] == [17]
    with VirtualUnit(seed=12345678.0, supplied=True, late_by=0.1234567) as unit:
        assert unit.bus.fault_injector.late_by == 0.1234567
    with pytest.raises(UsageError, match="bogus"):
        VirtualUnit(bogus=1)


def test_nothing_is_kept_in_the_users_folders(tmp_path, monkeypatch):
    for name in ("HOME", "XDG_STATE_HOME", "XDG_CONFIG_HOME", "XDG_CACHE_HOME"):
        monkeypatch.setenv(name, str(tmp_path))
    monkeypatch.delenv("MIKAS_STATE", raising=False)
    with VirtualUnit() as unit, unit.connect() as ecu:
        ecu.set_list("TWAT")
        ecu.memory.ram.write(0x40, 1)
        ecu.memory.code.read_block(0, 1024)
    assert list(tmp_path.rglob("*.json*")) == []


PROJECT = """
import pytest

import mikas.testing
from mikas.errors import LinkLost
from mikas.testing.units import LineFault


def test_reads(car, virtual_ecu):
    car.set("TWAT", 110)
    assert virtual_ecu.read("TWAT")["TWAT"].value == 110
    assert len(car.requests) >= 1


@pytest.mark.mikas_car(model="5.4", faults="17,81")
def test_marked(virtual_ecu):
    assert virtual_ecu.version_code == 9
    assert [fault.code for fault in virtual_ecu.faults()] == [17, 81]


@pytest.mark.mikas_car(model="5.4", faults="17")
class TestClass:
    @pytest.mark.mikas_car(faults="81")
    def test_has_the_marks_of_both(self, virtual_ecu):
        assert virtual_ecu.version_code == 9
        assert [fault.code for fault in virtual_ecu.faults()] == [81]


def test_unplugged(car, virtual_ecu):
    car.unplug()
    with pytest.raises(LinkLost):
        virtual_ecu.read("TWAT")
"""


def run_pytest(folder):
    environment = {**os.environ, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    return subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "--strict-markers", "-W", "error",
         "-p", "mikas.testing.plugin", "-p", "no:cacheprovider", str(folder)],
        capture_output=True, text=True, env=environment, cwd=folder, check=False,
    )  # fmt: skip


def test_a_strangers_project_gets_the_fixtures(tmp_path):
    (tmp_path / "test_mine.py").write_text(PROJECT)
    done = run_pytest(tmp_path)
    assert "4 passed" in done.stdout, done.stdout + done.stderr


def test_the_plugin_imports_nothing_before_a_test_wants_it():
    code = "import sys, mikas.testing.plugin; print(sorted(m for m in sys.modules if 'mikas' in m))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "['mikas', 'mikas.testing', 'mikas.testing.plugin']"


def test_the_package_has_what_a_test_needs():
    assert set(mikas.testing.__all__) == {
        "LineFault", "LinkContract", "Peer", "RealTimeContract", "Rig", "VirtualUnit",
    }  # fmt: skip
    for name in mikas.testing.__all__:
        assert getattr(mikas.testing, name).__doc__
    assert dir(mikas.testing) == mikas.testing.__all__
    with pytest.raises(AttributeError, match="nonsense"):
        _ = mikas.testing.nonsense


def test_what_can_not_be_set_is_refused_with_a_word(unit):
    for act, words in (
        (lambda: unit.set("FUEL_FLOW", 1), "FUEL_FLOW is computed: set what .* FREQ, INJ"),
        (lambda: setattr(unit, "faults", [17, 300]), "0 to 255, not 300"),
        (lambda: unit.next_responses("vanished"), "allowed: lost, late"),
    ):
        with pytest.raises(UsageError, match=words):
            act()


def test_a_fault_may_be_given_by_its_value(unit):
    with unit.connect(retries=0) as ecu:
        ecu.read("TWAT")
        unit.next_responses("lost")
        with pytest.raises(LineError):
            ecu.read("TWAT")


def test_a_mark_without_a_name_is_refused(tmp_path):
    (tmp_path / "test_mine.py").write_text(
        "import pytest\n\n\n@pytest.mark.mikas_car('city')\ndef test_it(car):\n    pass\n"
    )
    done = run_pytest(tmp_path)
    assert "mikas_car takes options by name, as in mikas_car(scenario='city')" in done.stdout
