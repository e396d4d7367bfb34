"""The report on a fleet: figures ──► findings by rules ──► sentences ──► page."""
