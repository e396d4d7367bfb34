"""The tables of the dataset and the types of their columns; `samples` has the channels besides.

Every table has `car` and `day` from the folders (`car=…/day=…`), and `drive`. `time`: seconds from
the recording's first row, as in an export; `utc`: the same on the calendar, NULL where the clock
does not count from 1970.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

SMALL: Final[Mapping[str, Mapping[str, str]]] = {
    "drives": {
        "drive": "VARCHAR",
        "recording": "VARCHAR",
        "file": "VARCHAR",
        "began": "TIMESTAMP",
        "ended": "TIMESTAMP",
        "seconds": "DOUBLE",
        "rows": "BIGINT",
        "known_by": "VARCHAR",
        "name": "VARCHAR",
        "plate": "VARCHAR",
        "mileage": "BIGINT",
        "workshop": "VARCHAR",
        "model": "VARCHAR",
        "version_code": "VARCHAR",
        "passport": "VARCHAR",
        "virtual": "BOOLEAN",
        "port": "VARCHAR",
        "adapter": "VARCHAR",
        "fault_readings": "BIGINT",
        "gaps": "BIGINT",
        "damaged_places": "BIGINT",
        "warm_idle_seconds": "DOUBLE",
        "coolant_first": "DOUBLE",
        "warm_up_seconds": "DOUBLE",
        "program": "VARCHAR",
        "catalog": "VARCHAR",
        "interpretation": "VARCHAR",
        "verdict": "VARCHAR",
        "cause": "VARCHAR",
        "likelihood": "VARCHAR",
        "cause_en": "VARCHAR",
        "cause_ru": "VARCHAR",
        "engine_seconds": "DOUBLE",
        "idle_seconds": "DOUBLE",
        "litres": "DOUBLE",
        "kilometres": "DOUBLE",
        "litres_per_100_km": "DOUBLE",
    },
    "statistics": {
        "drive": "VARCHAR",
        "began": "TIMESTAMP",
        "channel": "VARCHAR",
        "unit": "VARCHAR",
        "state": "VARCHAR",
        "count": "BIGINT",
        "mean": "DOUBLE",
        "median": "DOUBLE",
        "low": "DOUBLE",
        "high": "DOUBLE",
        "least": "DOUBLE",
        "most": "DOUBLE",
    },
    "faults": {
        "drive": "VARCHAR",
        "reading": "BIGINT",
        "time": "DOUBLE",
        "utc": "TIMESTAMP",
        "code": "INTEGER",
        "en": "VARCHAR",
        "ru": "VARCHAR",
        "message": "BOOLEAN",
        "erased": "BOOLEAN",
        "before": "BOOLEAN",
    },
    "gaps": {
        "drive": "VARCHAR",
        "time": "DOUBLE",
        "utc": "TIMESTAMP",
        "seconds": "DOUBLE",
        "en": "VARCHAR",
        "ru": "VARCHAR",
    },
    "alarms": {
        "drive": "VARCHAR",
        "time": "DOUBLE",
        "utc": "TIMESTAMP",
        "channel": "VARCHAR",
        "level": "VARCHAR",
        "side": "VARCHAR",
        "bound": "DOUBLE",
        "times": "BIGINT",
        "seconds": "DOUBLE",
        "peak": "DOUBLE",
        "still": "BOOLEAN",
        "by_event": "BOOLEAN",
    },
}
"""The tables whose rows are few."""

EDITION: Final = 3
"""The edition of the columns. A recording added with another one is interpreted again."""

LATER: Final[Mapping[str, frozenset[str]]] = {
    "drives": frozenset(
        (
            "verdict",
            "cause",
            "likelihood",
            "cause_en",
            "cause_ru",
            "engine_seconds",
            "idle_seconds",
            "litres",
            "kilometres",
            "litres_per_100_km",
        )
    ),
}
"""Columns that a table of an earlier edition lacks: its rows have NULL there."""

_SAMPLES: Final = {"drive": "VARCHAR", "time": "DOUBLE", "utc": "TIMESTAMP"}
TABLES: Final[Mapping[str, Mapping[str, str]]] = {"samples": _SAMPLES, **SMALL}
PARTITIONS: Final = {"car": "VARCHAR", "day": "DATE"}
RESERVED: Final = frozenset((*_SAMPLES, *PARTITIONS))
"""No channel may have such a name, in capitals or not: the columns would be one."""
