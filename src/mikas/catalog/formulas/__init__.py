"""Formulas of derived channels: their syntax, their arithmetic, and their calculation."""
