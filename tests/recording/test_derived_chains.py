"""Derived channels that need each other: twice as many are twice the work, counted in calls."""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from itertools import pairwise

import pytest
from crafted_harness import calls

from dashboard.recordings_rig import record
from mikas.catalog import load, shipped
from mikas.client.parameters.derived import DerivedChannels
from mikas.dashboard.session.catalog_in_use import changed_channels, computing
from mikas.recording.recording import Recording
from mikas.recording.search import SearchCondition, search
from mikas.report.from_recording import find_in_recording
from mikas.sampling.plan import select

COUNT = 150


def channel(name, formula):
    return f'[derived.{name}]\nformula = "{formula}"\ntext = {{ en = "c", ru = "с" }}\n'


def chain(count):
    """Each channel needs the one before."""
    names = ["FREQ", *(f"C{number}" for number in range(count))]
    return "".join(channel(each, f"{before} + 1") for before, each in pairwise(names))


def lattice(count):
    """Each channel needs both of the two before, so there are 2^(count/2) ways through it."""
    text = channel("A0", "FREQ") + channel("B0", "FREQ")
    for number in range(1, count // 2):
        for letter in "AB":
            text += channel(f"{letter}{number}", f"A{number - 1} + B{number - 1}")
    return text


def continued(catalog):
    before = DerivedChannels(shipped(), shipped().derived)
    DerivedChannels(catalog, catalog.derived).continue_from(before, shipped().channels)


WORK = {
    "plan": lambda catalog, _: select(catalog, catalog.channels),
    "live": lambda catalog, _: continued(catalog),
    "changed": lambda catalog, _: changed_channels(catalog, replace(catalog)),
    "history": lambda catalog, _: computing(catalog, list(catalog.derived), "corrected"),
    "recording": lambda catalog, path: deque(Recording(path, catalog).rows(), 0),
    "find": lambda catalog, path: search(
        Recording(path, catalog), SearchCondition(catalog, list(catalog.derived)[-1])
    ),
    "report": lambda catalog, path: find_in_recording(Recording(path, catalog)),
}


@pytest.mark.parametrize("form", [chain, lattice])
@pytest.mark.parametrize("work", WORK.values(), ids=WORK)
def test_a_chain_of_derived_channels_is_work_in_proportion_to_its_length(work, form, tmp_path):
    drive, file = record(tmp_path / "drive.pcapng", count=10), tmp_path / "own.toml"
    counted = []
    for count in (COUNT, COUNT, 2 * COUNT):  # the first time some modules are imported
        file.write_text(form(count), "utf-8")
        counted.append(calls(lambda: work(load(file), drive)))
    _, once, twice = counted
    assert twice < 2.3 * once


def test_a_long_chain_is_compared_without_deep_recursion(tmp_path):
    file = tmp_path / "own.toml"
    file.write_text(chain(1900), "utf-8")
    assert not changed_channels(load(file), load(file))
