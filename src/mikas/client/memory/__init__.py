"""Memory of the ECU: cells and blocks of a space, and whole dumps with their manifest (§3)."""
