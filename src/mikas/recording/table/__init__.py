"""Recordings as tables: columns over time, derived channels, gaps, windows, data frames."""
