"""Runs of regular exchanges, for replay."""
