"""Builds what people install: wheel, source distribution, one-folder program, Debian package."""
