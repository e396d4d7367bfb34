"""files.json, and the version of the site in its service worker."""

from __future__ import annotations

import hashlib
import json

import pytest

from tools.site import listing


@pytest.fixture
def site(tmp_path):
    def build(text):
        folder = tmp_path / "site"
        (folder / "assets").mkdir(parents=True, exist_ok=True)
        (folder / "assets" / "page.js").write_text(text)
        (folder / "service-worker.js").write_bytes(b"version = 'MIKAS_SITE_VERSION'")
        (folder / "files.json").unlink(missing_ok=True)
        listing.complete(folder)
        return folder

    return build


def listed(folder):
    return json.loads((folder / "files.json").read_text())


def test_it_has_every_file_as_it_is(site):
    folder = site("page")
    files = listed(folder)["files"]
    assert [each["path"] for each in files] == ["assets/page.js", "service-worker.js"]
    for each in files:
        content = (folder / each["path"]).read_bytes()
        assert each["sha256"] == hashlib.sha256(content).hexdigest()
        assert each["bytes"] == len(content) >= each["compressed"]


def test_another_file_is_another_version_for_the_service_worker_too(site):
    before = listed(site("page"))["version"]
    assert before in (site("page") / "service-worker.js").read_text()
    assert listed(site("page"))["version"] == before
    after = listed(site("another page"))["version"]
    assert after != before
    assert after in (site("another page") / "service-worker.js").read_text()
