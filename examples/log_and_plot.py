"""Sample two parameters for three minutes, write drive.csv and draw drive.svg.

`mikas log` records every byte on the line instead; `mikas.open(FILE).to_pandas()` makes a table of
such a recording, and pandas plots it.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import mikas

PORT = sys.argv[1] if len(sys.argv) > 1 else "sim:?scenario=cold-start&clock=simulated"
SCALES = {"FREQ": (0, 2000, "green"), "TWAT": (-20, 100, "crimson")}  # lowest, highest, colour

with mikas.connect(PORT) as ecu:
    samples = list(ecu.watch(*SCALES, rate=2, count=360))
start = samples[0].time

with Path("drive.csv").open("w", newline="") as file:
    writer = csv.writer(file)
    writer.writerow(["time", *SCALES])
    for sample in samples:  # a value that could not be read is an empty cell
        values = [sample.readings[name].value if name in sample.readings else "" for name in SCALES]
        writer.writerow([f"{sample.time - start:.3f}", *values])

lines = []
for name, (low, high, colour) in SCALES.items():
    read = [(sample.time - start, sample.readings[name].value)
            for sample in samples if name in sample.readings]  # fmt: skip
    points = " ".join(f"{4 * x:.0f},{300 * (high - y) / (high - low):.0f}" for x, y in read)
    lines.append(f'<polyline fill="none" stroke="{colour}" points="{points}"/>')
Path("drive.svg").write_text(
    f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 720 300">{"".join(lines)}</svg>'
)
print(f"{len(samples)} samples in drive.csv, their picture in drive.svg")
