"""The Wireshark dissector: hand-written Lua files behind generated tables, in one file."""
