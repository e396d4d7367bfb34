"""Read a channel and a parameter that only your own catalog file knows.

On the command line: `mikas --catalog car.toml watch LOAD TWAT`.
"""

from __future__ import annotations

import sys
from pathlib import Path

import mikas

PORT = sys.argv[1] if len(sys.argv) > 1 else "sim:?clock=simulated"

with mikas.connect(PORT, catalogs=[Path(__file__).with_name("car.toml")]) as ecu:
    print("catalog", ecu.catalog.version)
    limits = ecu.catalog.parameter("TWAT").alarm_limits
    print(ecu.read("TWAT")["TWAT"], "danger above", limits and limits.danger_high)
    print(ecu.read("LOAD")["LOAD"])  # computed from JAIR
    try:
        print(ecu.read("BOOST")["BOOST"])
    except mikas.errors.NotSupported as error:  # this unit does not know code 33
        print(error)
