"""The figures of the report, collected from rows: statistics, warm idle, times beyond limits."""
