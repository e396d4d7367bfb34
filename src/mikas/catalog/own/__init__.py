"""The user's own catalog file, which the dashboard edits: `file` (load, change) over `editing`."""
