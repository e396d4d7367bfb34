"""What to request, by which method and how often; derived channels and alarms of the values."""
