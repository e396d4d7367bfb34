"""What other tools have made of a capture: found out, and made ready for reading in a copy."""
