"""Recordings as files: pcapng blocks, a scan that survives damage, reader, writer, notes."""
