"""Drives in a recording: from when the engine runs until it stops, with fuel, distance, idling.

Fuel comes from the unit, road speed from an instrument beside it. What a gap leaves out is no part
of a sum, and each sum says how many seconds it covers.
"""

from mikas.drives.finding import since_mark, trips
from mikas.drives.trip import LEAST_DISTANCE, Trip, joined_trips

__all__ = ["LEAST_DISTANCE", "Trip", "joined_trips", "since_mark", "trips"]
