"""Recorded exchanges: one interpretation of the traffic in a capture."""
