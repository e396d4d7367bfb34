"""The decoder for sigrok-cli and PulseView. `parts/` is its hand-written half."""

from mikas.dissectors.sigrok.folder import decoder_file
from mikas.dissectors.sigrok.generator import MARK, source

__all__ = ["MARK", "decoder_file", "source"]
