"""Reading and writing parameters: by code, by name, cycle by cycle, and the list in the unit."""
