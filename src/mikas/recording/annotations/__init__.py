"""Annotations of a recording: events as notes between the packets, and a person's comment."""
