"""Showing a recording frame by frame, with the meaning of each frame."""
