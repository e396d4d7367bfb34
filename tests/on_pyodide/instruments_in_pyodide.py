"""Instruments in the page's Python: an hour with one that is unplugged at random."""

from __future__ import annotations

import mikas
from unplugged_instruments import Unplugged, drive_with_outages


def test_an_hour_with_a_meter_unplugged_at_random_costs_the_unit_nothing(tmp_path):
    drive = drive_with_outages(
        tmp_path, lambda source, _, outages: Unplugged(source, outages), rate=1.0, alone_for=300
    )
    assert drive.meter.outages.count > 15
    recording = mikas.open(drive.path, names=["AFR"])
    found = [float(value) for rows in recording.rows() for value in rows.values["AFR"]]
    known = {value for value in found if value == value}
    assert known
    assert known <= drive.whole
    assert sum(value != value for value in found) > 0.1 * len(found)
