"""The virtual unit: a Mikas on its wire, with an engine behind it and an adapter in front (no
I/O).
"""
