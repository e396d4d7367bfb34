"""Commands on the connected unit."""
