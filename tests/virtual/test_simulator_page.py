"""docs/**/simulator.md has every setting of the virtual unit, with the default of the code."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from mikas.virtual.build import SETTINGS, build_bus
from tester.tester_rig import case

FOLDERS = ("docs", "docs/ru")
ROW = re.compile(r"^\| `([\w-]+)` \| (.+) \|$", re.MULTILINE)
# Another value for each setting whose default is written there.
OTHERS = {
    "model": "5.4", "baud": "4800", "stall_every": "9", "stall_ms": "70", "latency_ms": "16",
    "echo": "0", "supplied": "0", "late_by": "2", "turn_round": "0.1", "least_pause": "0.1",
    "turn_round_spread": "0.1", "inter_byte": "0.1", "unknown_body": "7F10", "accepts": "raw",
    "stream_gap": "0.1", "stream_load": "3", "bad_write": "silent", "unknown": "01",
    "max_list": "7", "max_list_61": "7", "max_list_64": "7", "max_list_71": "7",
    "max_block": "7", "long_list": "short",
    "counted_blocks": "1", "raw_checksum": "1", "stream_end": "break",
}  # fmt: skip


def settings(folder):
    """Each row of the tables of settings: its name, and its other cells."""
    page = (Path(__file__).parents[2] / folder / "reference" / "simulator.md").read_text("utf-8")
    _, _, behind = re.sub("Настройки", "Settings", page).partition("\n## Settings\n")
    return [(name, rest.split(" | ")) for name, rest in ROW.findall(behind) if name in SETTINGS]


def behaviour(bus):
    """All that the settings of the line, the adapter and the unit's oddities change."""
    stalls, faults = bus.adapter.stalls, bus.fault_injector
    return (
        bus.ecu.responder.quirks, bus.ecu.responder.identity, bus.ecu.baud, bus.adapter.kind,
        stalls.every, stalls.longest, faults.rates, faults.late_by,
    )  # fmt: skip


@pytest.mark.parametrize("folder", FOLDERS)
def test_every_setting_stands_there_once(folder):
    assert sorted(name for name, _ in settings(folder)) == sorted(SETTINGS)


@pytest.mark.parametrize("folder", FOLDERS)
def test_the_defaults_are_those_of_the_code(folder):
    usual, cells = behaviour(build_bus({})), dict(settings(folder))
    for name, other in OTHERS.items():
        (shown,) = re.findall(
            r"`([\w.]+)`" if name != "late_by" else r"`(0[.\d]+)`", cells[name][-1]
        )
        with case(name, shown):
            assert behaviour(build_bus({name: shown})) == usual
            assert behaviour(build_bus({name: other})) != usual  # the line above sees it
