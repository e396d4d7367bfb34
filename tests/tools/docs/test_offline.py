"""What a browser would load from elsewhere."""

from __future__ import annotations

import pytest
from tools.docs.offline import loaded_from_elsewhere


@pytest.mark.parametrize(
    ("name", "text", "found"),
    [
        ("a.html", '<a href="https://b.example">', 0),
        ("a.html", '<img src="https://b.example/c.png">', 1),
        ("a.html", '<img src="../c.png"><script src="d.js"></script>', 0),
        ("a.html", '<link rel="preconnect" href="//b.example">', 1),
        ("a.html", "<style>@import 'https://b.example/c.css'; p { background: url(//d) }", 2),
        ("a.html", '<pre class="mermaid">', 1),
        ("a.html", '<div data-md-component="source">', 1),
        ("a.html", "<p>pyodide and mermaid</p>", 0),
        ("a.css", '@font-face { src: url("https://b.example/c.woff2") }', 1),
        ("a.css", "p { background: url(data:image/svg+xml;utf8,<svg/>) }", 0),
        ("a.svg", '<svg xmlns="http://www.w3.org/2000/svg"><style>p { fill: red }</style>', 0),
        ("a.svg", '<svg><image xlink:href="https://b.example/c.png"/></svg>', 1),
    ],
)
def test_what_a_page_loads_from_elsewhere_is_found(tmp_path, name, text, found):
    (tmp_path / name).write_text(text)
    assert len(list(loaded_from_elsewhere(tmp_path))) == found
