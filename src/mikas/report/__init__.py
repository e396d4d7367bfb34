"""A report on one car for its owner: measured values, their rating, and what remains unknown.

    a recording ─► from_recording ─┐
                                   ├─► MeasurementCollector ─► findings ─► page ─► HTML
    a running session ─────────────┘                                       (charts)

Only `findings` rates values: at warm idle, against a reference of the catalog, or not at all.
"""
