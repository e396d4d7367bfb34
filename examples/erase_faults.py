"""Show the stored faults, ask, erase them and read back."""

from __future__ import annotations

import sys

import mikas

PORT = sys.argv[1] if len(sys.argv) > 1 else "sim:?faults=13,53&clock=simulated"


def confirm(change: mikas.Change) -> bool:
    """Ask before every change of the ECU; the change is written to the journal."""
    return input(f"{change.what.en}? [y/N] ").strip().lower() == "y"


with mikas.connect(PORT, confirm=confirm) as ecu:
    faults = ecu.faults()
    for fault in faults:
        print(fault.code, fault.text.en, f"({fault.confidence.value})")
    if faults:
        try:
            print("stored now:", [fault.code for fault in ecu.erase_faults().after])
        except mikas.errors.NotConfirmed:
            print("nothing was changed")
