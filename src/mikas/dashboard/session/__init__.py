"""One connection to a unit: its thread, its state, the plan, recording, dumps, diagnosis, changes.

Nothing here knows HTTP. The other modules use `connection`.
"""
