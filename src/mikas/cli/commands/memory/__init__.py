"""Commands on the unit's memory: `mikas mem`."""
