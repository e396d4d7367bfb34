"""What to ask, how and how often; and what is made of the answers: derived channels, alarms."""
