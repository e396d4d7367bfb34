"""Clients of every manner, before the dashboard's server: `python -m fuzz clients`.

`caller` is a client byte by byte, with TLS or without; `manners` are the ways in which one comes,
stays and goes; `world` is a dashboard that samples and records meanwhile, and says what went wrong;
`campaign` draws manners from a seed. The tests of the dashboard run each manner once.
"""
