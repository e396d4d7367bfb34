"""Routes of the actions on conditions."""
