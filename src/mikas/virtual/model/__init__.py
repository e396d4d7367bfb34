"""The virtual car itself: engine, car, driver and the control program, on a fixed grid of time."""
