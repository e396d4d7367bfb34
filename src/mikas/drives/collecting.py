"""The trips of rows that come stretch by stretch, as a dataset gets them: read once, for all."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from mikas.drives.finding import trips_of_rows
from mikas.drives.trip import Trip, joined_trips
from mikas.recording.table.channels import Rows

if TYPE_CHECKING:
    from mikas.recording.recording import Recording


class TripCollector:
    """Keeps what trips need of the rows of one port in one session: 32 bytes a row."""

    def __init__(self) -> None:
        self._rows: list[Rows] = []

    def add(self, rows: Rows) -> None:
        """Add rows, parameters in the corrected interpretation."""
        if not len(rows.times) or "FREQ" not in rows.values:
            return
        fuel = "JQT" if "JQT" in rows.values else "FUEL_FLOW"
        kept = {name: rows.values[name] for name in ("FREQ", "RXX", fuel) if name in rows.values}
        self._rows.append(Rows(rows.times, kept))

    def whole(self, recording: Recording, session: int) -> Trip | None:
        """Return the sums of all trips; None if the engine did not run, or FREQ was not read."""
        return joined_trips(trips_of_rows(recording, session, self._rows))

    def columns(self, recording: Recording, session: int) -> Mapping[str, object]:
        """Return the columns of the table `drives`."""
        trip = self.whole(recording, session)
        return {
            "engine_seconds": trip.seconds if trip else None,
            "idle_seconds": trip.idle_seconds if trip else None,
            "litres": trip.litres if trip else None,
            "kilometres": trip.kilometres if trip else None,
            "litres_per_100_km": trip.litres_per_100_km if trip else None,
        }
