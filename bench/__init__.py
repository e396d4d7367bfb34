"""Figures that the README and the docs quote: `make bench`, or `python -m bench`. Not part of the
tests.
"""
