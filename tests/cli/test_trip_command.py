"""`mikas trip` on a recording with a receiver beside the unit."""

from __future__ import annotations

import pytest

MADE: dict[str, bytes] = {}
"""The recording, once it was made: that takes a second."""


@pytest.fixture
def city(mikas, tmp_path):
    path = tmp_path / "a.pcapng"
    if not MADE:
        port = ("--port", "sim:?clock=simulated&scenario=city&seed=3")
        ran = mikas(
            *port, "log", "-o", path.name, "FREQ", "JQT", "RXX", "--rate", "2", "--duration", "120",
            "--instrument", "nmea=sim:",
        )  # fmt: skip
        assert ran.status == 0
        MADE["city"] = path.read_bytes()
    path.write_bytes(MADE["city"])
    return path


def test_trip_shows_a_row_a_drive_and_the_total_of_several(mikas, city):
    ran = mikas("trip", "a.pcapng", "--json")
    assert ran.status == 0
    (drive,) = ran.object["trips"]
    assert drive["file"].endswith("a.pcapng")
    assert ran.object["since"] is None
    assert 115 < drive["seconds"] < 121
    assert 0.02 < drive["litres"] < 1
    assert 0.05 < drive["kilometres"] < 2
    assert 0 < drive["idle_seconds"] < drive["idle_known"] <= drive["seconds"] + 1e-6
    assert {name: drive[name] for name in drive if name != "file"} == ran.object["total"]
    ran = mikas("trip", "a.pcapng")
    assert len(ran.lines) == 2
    assert ran.lines[1].split("\t")[3:6] == [
        f"{drive['litres']:.2f}", f"{drive['kilometres']:.1f}", "–",
    ]  # fmt: skip
    assert "less than 1 km" in ran.err or drive["kilometres"] >= 1
    mikas.speaks("ru")
    ran = mikas("trip", "a.pcapng", "a.pcapng")
    assert len(ran.lines) == 4
    assert ran.lines[-1].startswith("всего\t")
    assert ran.lines[-1].split("\t")[3] == f"{2 * drive['litres']:.2f}".replace(".", ",")


def test_trip_names_what_it_lacks(mikas, city):
    assert mikas("trip").status == 2
    ran = mikas("trip", "a.pcapng", "--since", "home")
    assert ran.status == 2
    assert "no mark" in ran.err
    data = bytearray(city.read_bytes())
    data[-3000:-2900] = bytes(100)
    city.write_bytes(data)
    ran = mikas("trip", "a.pcapng")
    assert (ran.status, len(ran.lines)) == (0, 2)
    assert "damaged" in ran.err
