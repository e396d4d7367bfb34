"""The virtual unit: a Mikas on its wire, with an engine model and an adapter (no I/O)."""

VIRTUAL_PASSPORT = "ВИРТУАЛЬНЫЙ БЛОК"
"""A piece of the passport of every virtual unit that is not given passports of its own."""
