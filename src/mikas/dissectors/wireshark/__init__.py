"""The Wireshark dissector: hand-written Lua files behind generated tables.

`source` is the whole dissector as one file, as Wireshark loads it from `plugin_file`.
"""

from mikas.dissectors.wireshark.generator import MARK, in_ascii, source
from mikas.dissectors.wireshark.plugin import plugin_file

__all__ = ["MARK", "in_ascii", "plugin_file", "source"]
