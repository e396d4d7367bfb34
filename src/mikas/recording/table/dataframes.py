"""A recording as a data frame: pandas, polars or Arrow, whichever is installed.

Columns are named as the channels; `time` counts seconds from the first row, or is the date and the
time of day in a zone. A missing value is NaN
in numbers and null in flags (polars and Arrow: null in both). Units and texts are in a pandas
frame's `attrs` and in the metadata of Arrow's fields and schema; polars has no place for them.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from mikas import errors
from mikas.i18n import Text
from mikas.json_values import json_of
from mikas.recording.exchanges.arrays import Floats
from mikas.recording.table.channels import Channel

if TYPE_CHECKING:
    import pandas as pd
    import polars as pl
    import pyarrow as pa

_TIME_TEXT: Final = Text("Time since the start", "Время от начала")
_DATE_TEXT: Final = Text("Date and time", "Дата и время")


@dataclass(frozen=True, slots=True)
class Table:
    """The whole recording in memory. `facts`: JSON values by title.

    `moments`: the times in microseconds from 1970, if they are shown in `zone` instead of `times`.
    """

    channels: Sequence[Channel]
    times: Floats
    values: Mapping[str, Floats]
    facts: dict[str, Any]
    moments: NDArray[np.int64] | None = None
    zone: str = "UTC"


def library(name: str) -> Any:  # noqa: ANN401  (a module that may not be installed)
    """Import the library. Raises `MissingExtra` with the command that installs it."""
    return errors.library(
        name,
        feature=Text(f"A table for {name}", f"Таблица для {name}"),
        advice=Text(f"Install it with: pip install {name}.", f"Установите: pip install {name}."),
    )


def pandas_frame(table: Table) -> pd.DataFrame:
    """Return a `pandas.DataFrame`, its index `time`."""
    pandas = library("pandas")
    columns = dict(table.values)
    for channel in table.channels:
        if channel.is_flag:
            values = columns[channel.name]
            columns[channel.name] = pandas.arrays.BooleanArray(values == 1, np.isnan(values))
    index = pandas.Index(table.times)
    if table.moments is not None:
        index = pandas.to_datetime(table.moments, unit="us", utc=True).tz_convert(table.zone)
    frame: pd.DataFrame = pandas.DataFrame(columns, index=index.rename("time"))
    frame.attrs.update(table.facts)
    return frame


def polars_frame(table: Table) -> pl.DataFrame:
    """Return a `polars.DataFrame`."""
    polars = library("polars")
    columns = [polars.Series("time", table.times)]
    if table.moments is not None:
        moments = polars.Series("time", table.moments).cast(polars.Datetime("us", "UTC"))
        columns = [moments.dt.convert_time_zone(table.zone)]
    for channel in table.channels:
        column = polars.Series(channel.name, table.values[channel.name], nan_to_null=True)
        columns.append(column.cast(polars.Boolean) if channel.is_flag else column)
    frame: pl.DataFrame = polars.DataFrame(columns)
    return frame


def arrow_table(table: Table) -> pa.Table:
    """Return a `pyarrow.Table`; its schema's metadata has the facts as JSON, by the key `mikas`."""
    arrow = library("pyarrow")
    fields = [arrow.field("time", arrow.float64(), metadata=_about("s", _TIME_TEXT))]
    arrays = [arrow.array(table.times)]
    if table.moments is not None:
        kind = arrow.timestamp("us", tz=table.zone)
        fields = [arrow.field("time", kind, metadata=_about("", _DATE_TEXT))]
        arrays = [arrow.array(table.moments).cast(kind)]
    for channel in table.channels:
        values = table.values[channel.name]
        kind = arrow.bool_() if channel.is_flag else arrow.float64()
        data = values == 1 if channel.is_flag else values
        arrays.append(arrow.array(data, kind, mask=np.isnan(values)))
        fields.append(arrow.field(channel.name, kind, metadata=_about(channel.unit, channel.text)))
    facts = json.dumps(table.facts, ensure_ascii=False)
    made: pa.Table = arrow.Table.from_arrays(arrays, schema=arrow.schema(fields, {"mikas": facts}))
    return made


def _about(unit: str, text: Text) -> dict[str, str]:
    return {"unit": unit, **json_of(text)}
