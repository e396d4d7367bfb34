"""This computer in its networks: its addresses, and the sockets on which the dashboard listens."""
