"""Commands on the unit's memory."""
