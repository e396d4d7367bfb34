"""The tables of the dataset and their columns; `samples` has a column for each channel besides.

Every table has `car` and `day` from the folders (`car=…/day=…`), and `drive`. `time`: seconds from
the recording's first row, as in an export; `utc`: the same on the calendar, NULL where the clock
does not count from 1970.
"""

from __future__ import annotations

from typing import Final, NamedTuple


class TableColumn(NamedTuple):
    """A column: its name and its type in duckdb."""

    name: str
    type: str


def _columns(text: str) -> tuple[TableColumn, ...]:
    return tuple(TableColumn(*line.split()) for line in text.strip().splitlines())


SAMPLES: Final = _columns(
    """
    drive VARCHAR
    time DOUBLE
    utc TIMESTAMP
    """
)
"""Before the channels."""

DRIVES: Final = _columns(
    """
    drive VARCHAR
    recording VARCHAR
    file VARCHAR
    began TIMESTAMP
    ended TIMESTAMP
    seconds DOUBLE
    rows BIGINT
    known_by VARCHAR
    name VARCHAR
    plate VARCHAR
    mileage BIGINT
    workshop VARCHAR
    model VARCHAR
    version_code VARCHAR
    passport VARCHAR
    virtual BOOLEAN
    port VARCHAR
    adapter VARCHAR
    fault_readings BIGINT
    gaps BIGINT
    damaged_places BIGINT
    warm_idle_seconds DOUBLE
    coolant_first DOUBLE
    warm_up_seconds DOUBLE
    program VARCHAR
    catalog VARCHAR
    interpretation VARCHAR
    """
)
STATISTICS: Final = _columns(
    """
    drive VARCHAR
    began TIMESTAMP
    channel VARCHAR
    unit VARCHAR
    state VARCHAR
    count BIGINT
    mean DOUBLE
    median DOUBLE
    low DOUBLE
    high DOUBLE
    least DOUBLE
    most DOUBLE
    """
)
FAULTS: Final = _columns(
    """
    drive VARCHAR
    reading BIGINT
    time DOUBLE
    utc TIMESTAMP
    code INTEGER
    en VARCHAR
    ru VARCHAR
    message BOOLEAN
    erased BOOLEAN
    before BOOLEAN
    """
)
GAPS: Final = _columns(
    """
    drive VARCHAR
    time DOUBLE
    utc TIMESTAMP
    seconds DOUBLE
    en VARCHAR
    ru VARCHAR
    """
)
ALARMS: Final = _columns(
    """
    drive VARCHAR
    time DOUBLE
    utc TIMESTAMP
    channel VARCHAR
    level VARCHAR
    side VARCHAR
    bound DOUBLE
    times BIGINT
    seconds DOUBLE
    peak DOUBLE
    still BOOLEAN
    by_event BOOLEAN
    """
)
SMALL: Final = {
    "drives": DRIVES,
    "statistics": STATISTICS,
    "faults": FAULTS,
    "gaps": GAPS,
    "alarms": ALARMS,
}
"""The tables whose rows are few."""

TABLES: Final = {"samples": SAMPLES, **SMALL}
PARTITIONS: Final = (TableColumn("car", "VARCHAR"), TableColumn("day", "DATE"))
RESERVED: Final = frozenset(column.name for column in (*SAMPLES, *PARTITIONS))
"""No channel may have such a name, in capitals or not: the columns would be one."""
