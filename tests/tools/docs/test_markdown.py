"""What a Markdown file consists of, and the same in the dialect of the site."""

from __future__ import annotations

import pytest
from tools.docs.dialect import rewritten
from tools.docs.markdown import Document, slug_of, slugs, with_targets

PAGE = """\
# One
Words, [a link](b.md#c "title"), ![a picture](d/e.png), `[no](link.md)`.

<!-- [no](comment.md) --> <a id="own"></a> <img src="f.svg" alt="">

```console no-run
$ mikas read [not](here.md)
```

## One
[![both](g.png)](https://h.example/i)
"""


def test_links_are_found_where_they_are_links():
    page = Document(PAGE)
    assert [(each.target, each.picture, each.line) for each in page.links] == [
        ("b.md#c", False, 2),
        ("d/e.png", True, 2),
        ("f.svg", True, 4),
        ("g.png", True, 11),
        ("https://h.example/i", False, 11),
    ]
    assert [each.external for each in page.links] == [False] * 4 + [True]
    assert (page.links[0].path, page.links[0].anchor) == ("b.md", "c")


def test_headings_have_the_anchors_of_github():
    assert [(each.level, each.anchor) for each in Document(PAGE).headings] == [
        (1, "one"),
        (2, "one-1"),
    ]
    assert Document(PAGE).anchors == {"one", "one-1", "own"}


@pytest.mark.parametrize(
    ("words", "anchor"),
    [
        ("§2.2 Byte stuffing", "22-byte-stuffing"),
        ("The unit's list: `list set`, `list read`", "the-units-list-list-set-list-read"),
        ("Проверка связи — кратко", "проверка-связи--кратко"),
        ("[A link](x.md) *here*", "a-link-here"),
        ("snake_case & more", "snake_case--more"),
    ],
)
def test_a_heading_has_the_anchor_of_github(words, anchor):
    assert slug_of(words) == anchor


def test_code_has_its_place_and_language():
    (code,) = Document(PAGE).code
    assert (code.language, code.info, code.line) == ("console", "console no-run", 6)
    assert code.text == "$ mikas read [not](here.md)\n"


def test_only_the_targets_that_are_given_change():
    page = Document(PAGE)
    changed = with_targets(page, {page.links[1].start: "j.png"})
    assert changed == PAGE.replace("d/e.png", "j.png")


@pytest.mark.parametrize(
    ("text", "in_the_dialect"),
    [
        ("Words:\n- a\n- b", "Words:\n\n-   a\n-   b"),
        ("- a\n  on\n  - b\n    on\n- c", "-   a\n    on\n    -   b\n        on\n-   c"),
        ("1. a\n   - b\n\n     c\n2. d", "1.  a\n    -   b\n\n        c\n2.  d"),
        ("- a\nlazy", "-   a\n    lazy"),
        ("Words:\n| a |\n|---|\n| b |", "Words:\n\n| a |\n|---|\n| b |"),
        ("# A\n\n```\n- a\n  - b\n```", "# A\n\n```\n- a\n  - b\n```"),
        ("- a\n  ```\n  b\n    c\n  ```", "-   a\n    ```\n    b\n      c\n    ```"),
        ("```console no-run\n$ a\n```\n\n## B", "```console\n$ a\n```\n\n## B"),
        (
            "- a\n\n  ```text\n  ```python no-run\n  ```",
            "-   a\n\n    ```text\n    ```python no-run\n    ```",
        ),
    ],
)
def test_lists_tables_and_code_in_the_dialect_of_python_markdown(text, in_the_dialect):
    assert rewritten(text) == in_the_dialect + "\n"


def test_a_clause_has_its_own_anchor_on_the_site_and_that_of_its_words_on_github():
    heading = '## <a id="s4-2"></a><a id="errata"></a>§4.2 Errata'
    assert rewritten(heading) == '## <a id="errata"></a>§4.2 Errata\n'
    assert rewritten('## <a id="changes"></a>Changes').startswith('## <a id="changes">')
    assert slugs()("§4.2 Errata", "-") == "s4-2"
    assert slugs()("Of §4.2", "-") == slug_of("Of §4.2") == "of-42"
    assert {"s4-2", "errata", "42-errata"} == Document(heading).anchors
