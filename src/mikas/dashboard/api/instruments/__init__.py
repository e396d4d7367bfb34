"""Routes of the instruments beside the unit."""
