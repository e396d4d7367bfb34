"""Decoders of this protocol for other programs: Wireshark (`wireshark/`), sigrok (`sigrok/`).

Each is a hand-written file in that program's language, in front of which its generator prints the
data of `tables`: commands, parameters, faults and models.
"""
