"""The HTTP and WebSocket API: a module of routes for each resource, their models, errors.

Routes get what they need from `dependencies` and raise errors of `mikas.errors` or
`mikas.dashboard.errors`; `errors` turns them into responses.
"""
