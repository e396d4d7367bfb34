"""The unit's memory: spaces to read (`spaces`) and to write (`writing`)."""
