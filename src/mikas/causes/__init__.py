"""From values to causes: the faults of a car, with the evidence for and against each."""
