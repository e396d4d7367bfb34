"""Live values as the command line and the dashboard have them: `mikas.session`."""
