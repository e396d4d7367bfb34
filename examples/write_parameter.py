"""Write a parameter: the change is shown, confirmed, made, read back, and kept in a journal."""

from __future__ import annotations

import sys

import mikas

PORT = sys.argv[1] if len(sys.argv) > 1 else "sim:?clock=simulated"


def confirm(change: mikas.Change) -> bool:
    """Show the change and ask. Only True makes it; anything but True and False is a TypeError."""
    print(f"{change.what.en} ({change.command}, {change.safety.name.lower()})")
    if change.old and change.new:
        print(f"  {change.name}: {change.old.en} → {change.new.en}")
    if change.warning:
        print(f"  {change.warning.en}")
    return input("Make this change? [y/N] ").strip().lower() == "y"


with mikas.connect(PORT, confirm=confirm, journal="journal.jsonl") as ecu:
    try:
        written = ecu.write_parameter("UOZ", 12.5)
    except mikas.errors.NotConfirmed:
        print("nothing was changed")
    except mikas.errors.WriteRefused as error:  # the unit said no, or keeps another value
        print(error)
    else:
        print("before:", written.before, "now:", written.after)
