"""One connection to a unit: its thread, its state, the plan, recording, dumps, diagnosis, changes.

Nothing here knows HTTP. `connection` stands beneath the other modules.
"""
