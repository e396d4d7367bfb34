"""Routes of channels: their definitions, changes in the user's own catalog, trials, one value."""
