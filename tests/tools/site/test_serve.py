"""The site on this computer: types, caching, and only what is in it."""

from __future__ import annotations

import threading
from contextlib import contextmanager
from http.client import HTTPConnection

import pytest

from tools.site import serve

pytestmark = pytest.mark.realtime


@contextmanager
def serving(folder, port=0):
    with serve.server_of(folder, port) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield server.server_port
        finally:
            server.shutdown()
            thread.join()


def response(port, path):
    connection = HTTPConnection("127.0.0.1", port)
    connection.request("GET", path)
    got = connection.getresponse()
    got.read()
    connection.close()
    return got


def test_files_have_their_type_and_versioned_ones_are_cached(tmp_path):
    for name in ("index.html", "files.json", "service-worker.js", "manifest.webmanifest"):
        (tmp_path / name).write_text("x")
    (tmp_path / "program-0123").mkdir()
    for name in ("pyodide.mjs", "pyodide.asm.wasm", "program.pack"):
        (tmp_path / "program-0123" / name).write_text("x")
    expected = {
        "/": ("text/html", "no-cache"),
        "/files.json": ("application/json", "no-cache"),
        "/service-worker.js": ("text/javascript", "no-cache"),
        "/manifest.webmanifest": ("application/manifest+json", "no-cache"),
        "/program-0123/pyodide.mjs": ("text/javascript", "immutable"),
        "/program-0123/pyodide.asm.wasm": ("application/wasm", "immutable"),
        "/program-0123/program.pack": ("application/octet-stream", "immutable"),
    }
    with serving(tmp_path) as port:
        for path, (kind, caching) in expected.items():
            got = response(port, path)
            assert (got.status, got.getheader("Content-Type")) == (200, kind), path
            assert caching in got.getheader("Cache-Control"), path
        assert response(port, "/../secret").status == 404
        missing = response(port, "/program-0123/stdlib.pack")  # the next build may have it
        assert (missing.status, missing.getheader("Cache-Control")) == (404, "no-cache")


def test_a_port_that_is_taken_is_no_hindrance(tmp_path):
    (tmp_path / "index.html").write_text("x")
    with serving(tmp_path) as first, serving(tmp_path, first) as second:
        assert first != second
        assert response(second, "/").status == 200


@pytest.mark.parametrize("taken", [False, True])
def test_another_address_does_not_show_the_recordings_of_the_usual_one(
    tmp_path, monkeypatch, capsys, taken
):
    (tmp_path / "index.html").write_text("x")
    monkeypatch.setattr(serve, "SITE", tmp_path)
    monkeypatch.setattr("sys.argv", ["serve"])
    shown = []

    def ctrl_c(address):
        shown.append(address)
        raise KeyboardInterrupt

    with serve.server_of(tmp_path, 0) as usual:
        monkeypatch.setattr(serve, "PORT", usual.server_port)
        if not taken:
            usual.server_close()
        assert serve.main(ctrl_c) == 0
    said = capsys.readouterr().out
    assert shown[0] in said
    assert ("recordings" in said) is taken
    assert (f":{usual.server_port}/" in shown[0]) is not taken
