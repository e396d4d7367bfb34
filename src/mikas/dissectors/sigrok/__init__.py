"""The decoder for sigrok-cli and PulseView. `parts/` is its hand-written half."""
