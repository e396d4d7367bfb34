"""The server behind the page: everything the tester can do, as an HTTP and WebSocket API.

`app.create_app` makes the application of a `Hub` (one unit, one sampling thread, one recorder) and
of an `Access` (who may ask, from where). `server.serve` runs it. The API is described in
docs/api.md and, by the application itself, at /api/docs.
"""
