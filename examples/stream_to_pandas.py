"""Sample as fast as the line allows into a pandas table, with a recording of all bytes beside it.

A lost adapter or unit is waited for; the table then has a hole, never a repeated value.
"""

from __future__ import annotations

import sys

import mikas
from mikas.sampling.events import AlarmChanged, Gap, MethodChosen

PORT = sys.argv[1] if len(sys.argv) > 1 else "sim:?clock=simulated&scenario=city&seed=1"
CHANNELS = ["FREQ", "JAIR", "TWAT/10", "FUEL_FLOW"]  # every tenth cycle; computed from INJ

with mikas.session(PORT, CHANNELS, record="drive.pcapng") as session:
    session.on(MethodChosen, lambda event: print("method:", event.method))
    session.on(AlarmChanged, lambda event: print("alarm:", event.text.en))
    session.on(Gap, lambda event: print("gap:", event.reason))
    frame = session.to_pandas(duration=30)

print(f"{len(frame)} rows, {frame['TWAT'].count()} of them with TWAT")
print(frame.resample("10s").mean().round(1).to_string(index=False))
