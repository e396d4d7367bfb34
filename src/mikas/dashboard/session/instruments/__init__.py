"""Instruments beside the unit in the dashboard: which there are, and their values on its line."""
