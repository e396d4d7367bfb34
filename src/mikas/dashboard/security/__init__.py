"""Rights: access by host and token, the control lease, ports, the write lock, confirmations."""
