"""The documentation in Chromium. Skipped where it is missing, unless `MIKAS_REQUIRE_CHROMIUM` is
set: then that is a failure.
"""

from __future__ import annotations

import threading
from pathlib import Path

import pytest
from tools.site.serve import server_of

from browser.chromium_rig import installed, must_not_miss, started

BUILT = Path(__file__).parents[2] / "build" / "docs"


@pytest.fixture(scope="package")
def chromium():
    program = installed()
    must_not_miss("" if program else "Chromium is not installed")
    must_not_miss("" if (BUILT / "index.html").is_file() else "not built: make docs")
    with started(program) as browser:
        yield browser


@pytest.fixture(scope="package", params=["server", "files"])
def address(request):
    """Where the documentation is: below an address of a server, or as files."""
    if request.param == "files":
        yield BUILT.as_uri()
        return
    with server_of(BUILT.parent, 0) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield f"http://127.0.0.1:{server.server_port}/docs"
        server.shutdown()
        thread.join()


@pytest.fixture
def reader(chromium, address):
    """Open a page in a browser that can reach nothing but the documentation."""
    contexts = []

    def read(path, **wishes):
        context = chromium.new_context(**wishes)
        contexts.append(context)
        page = context.new_page()
        page.complaints = []
        page.on("request", lambda it: _note(page, it.url, address))
        page.on("requestfailed", lambda it: _failed(page, it))
        page.on("pageerror", lambda it: page.complaints.append(str(it)))
        page.on("console", lambda it: it.type == "error" and page.complaints.append(it.text))
        context.route(lambda url: not _inside(url, address), lambda route: route.abort())
        page.goto(f"{address}/{path}")
        return page

    yield read
    for context in contexts:
        complaints = [each for page in context.pages for each in page.complaints]
        context.close()
        assert complaints == []


def _failed(page, request):
    if request.failure != "net::ERR_ABORTED":  # the reader went on
        page.complaints.append(f"{request.failure}: {request.url}")


def _inside(url, address):
    return url.startswith((f"{address}/", "data:", "about:", "blob:"))


def _note(page, url, address):
    if not _inside(url, address):
        page.complaints.append(f"leaves the documentation: {url}")
