"""Scenarios of the virtual car: the shipped files, their form, the timeline of inputs."""
