"""The job of `mikas fleet add` as one would write it by hand, with pandas.

python -m bench.fleet_by_hand FOLDER OUT
"""

from __future__ import annotations

import sys
from pathlib import Path

import pandas as pd

import mikas


def main() -> None:
    folder, out = map(Path, sys.argv[1:])
    for file in sorted(folder.rglob("*.pcapng")):
        recording = mikas.open(file)
        frame = recording.to_pandas()
        started = pd.Timestamp(frame.attrs["started"])
        frame["utc"] = started + pd.to_timedelta(frame.index, unit="s")
        frame["day"] = frame["utc"].dt.date.astype(str)
        frame["car"] = recording.about.get("passport", "unknown")
        frame.attrs = {}
        frame.to_parquet(out, partition_cols=["car", "day"])


if __name__ == "__main__":
    main()
