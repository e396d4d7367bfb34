"""From values to causes: what is wrong with the car, with the evidence for and against it."""
