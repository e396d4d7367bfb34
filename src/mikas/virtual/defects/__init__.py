"""Defects of the virtual car as data, and the cars that have them."""
