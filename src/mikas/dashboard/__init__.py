"""The server of the page: everything the tester can do, as an HTTP and WebSocket API.

    app ─ api/ ─ dashboard ─ session/ ─ library/ ─ security/ ─ settings, errors

`app.create_app` creates the application of a `Dashboard` (one unit, one sampling thread, one
recorder) and of an `Access` (the rights of a request). `server.serve` runs it.
docs/reference/api.md and, on a running program, /api/docs describe the API.
"""
