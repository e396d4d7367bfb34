"""The documentation beside the page without installation."""

from __future__ import annotations

from tools.docs.checking import built
from tools.docs.joining import join
from tools.docs.pages import LANGUAGES, ROOT


def test_front_pages_lead_to_the_page(tmp_path):
    docs, site = tmp_path / "docs", tmp_path / "site"
    for language in LANGUAGES:
        home = ROOT / "docs" / ("ru" if language == "ru" else "")
        (docs / language).mkdir(parents=True)
        (docs / language / "index.html").write_text((home / "index.md").read_text("utf-8"), "utf-8")
        (docs / language / "other.html").write_text("<p>")
        (docs / language / "tutorials").mkdir()
        owner = (home / "tutorials" / "owner.md").read_text("utf-8")
        (docs / language / "tutorials" / "owner.html").write_text(owner, "utf-8")
    (site / "docs" / "old").mkdir(parents=True)
    (site / "index.html").write_text("<p>")
    join(docs, site)
    assert not (site / "docs" / "old").exists()
    assert list(built.findings(site)) == []
    for language in LANGUAGES:
        assert 'href="../../index.html"' in (site / "docs" / language / "index.html").read_text()
        tutorial = site / "docs" / language / "tutorials" / "owner.html"
        assert 'href="../../../index.html"' in tutorial.read_text("utf-8")
        assert 'href="../../index.html"' not in (docs / language / "index.html").read_text("utf-8")
