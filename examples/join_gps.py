"""Resample a recording to a second, join it with a GPS track, and show litres for 100 km.

    python examples/join_gps.py drive.pcapng track.csv

The track has the columns time (ISO 8601 with its zone), lat, lon, speed (m/s). Without files the
program records a virtual drive and invents a track.
"""

from __future__ import annotations

import sys
from datetime import timedelta

import pandas as pd

import mikas

ZONE = "Europe/Moscow"
BEGIN = pd.Timestamp("2026-07-01 12:00", tz=ZONE)


def drive(file: str) -> pd.DataFrame:
    """Return the recording by the time of day, a row a second."""
    with mikas.open(file, names=["FREQ", "FUEL_FLOW"]) as recording:
        try:
            table = recording.to_pandas(time="clock", zone=ZONE)
        except mikas.errors.UsageError:  # simulated time has no date
            table = recording.to_pandas()
            table.index = BEGIN + pd.to_timedelta(table.index, unit="s")
    return table.resample("1s").mean()


if len(sys.argv) > 2:
    log, track = sys.argv[1], pd.read_csv(sys.argv[2], parse_dates=["time"], index_col="time")
else:
    log = "city.pcapng"
    with mikas.session("sim:?clock=simulated&scenario=city", ["INJ", "FREQ"], record=log) as city:
        city.run(duration=60)
    seconds = pd.date_range(BEGIN, periods=60, freq="1s")
    track = pd.DataFrame({"lat": 56.3, "lon": 44.0, "speed": 9.0}, index=seconds)

track = track.tz_convert(ZONE)
nearest = drive(log).reindex(track.index, method="nearest", tolerance=timedelta(seconds=1))
joined = track.join(nearest)  # a second without values stays empty
joined["l/100 km"] = joined["FUEL_FLOW"] / (3.6 * joined["speed"]) * 100
print(joined.iloc[::10].round(1).to_string())
print(f"{joined['l/100 km'].mean():.1f} l/100 km over {joined['speed'].sum() / 1000:.2f} km")
