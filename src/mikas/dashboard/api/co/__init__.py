"""Setting the idle CO by a meter."""
