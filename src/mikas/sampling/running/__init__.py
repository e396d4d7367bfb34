"""Running a plan on a unit: cycles, trials of the methods, parameters that the unit refuses."""
