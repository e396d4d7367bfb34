"""Adapters behind a network: TCP, Telnet with RFC 2217, and who answers there instead of one."""
