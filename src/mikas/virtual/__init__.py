"""The virtual unit: a Mikas on its wire, with an engine model and an adapter (no I/O)."""
