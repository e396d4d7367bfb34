"""A report on one car for its owner: what was measured, what that means, what could not be known.

    a recording ─ gathering ─┐                       ┌─ page ─► HTML   (plots: its charts)
    a running session ───────┴► MeasurementCollector ─► findings ┘

`findings` is where judging happens, and only there: a value is judged at warm idle, against a
reference of the catalog, or not at all.
"""
