"""The Wireshark dissector: hand-written Lua files behind generated tables.

`source` is the whole dissector as one file, as Wireshark loads it.
"""

from mikas.dissectors.wireshark.generator import source

__all__ = ["source"]
