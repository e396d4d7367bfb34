"""The form of a unit's profile as a file, and its codes."""
