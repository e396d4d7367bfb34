"""Weigh what speaks for a cause: simulated cars with known defects, and the table made of them."""
