"""The reference of the library has each public name and each of its members, with a docstring."""

from __future__ import annotations

from importlib import import_module

import pytest
from tools.docs.generated.error_fields import MEANINGS
from tools.docs.generated.python_members import Name
from tools.docs.generated.python_pages import PAGES, path_of, places, python_page
from tools.docs.markdown import Document
from tools.docs.pages import LANGUAGES

import mikas
from mikas import errors

PUBLIC = ("mikas", "mikas.client", "mikas.catalog", "mikas.link", "mikas.testing")
NAMES = [name for page in PAGES for name in page.names]


@pytest.fixture(scope="module")
def pages():
    places()
    return {page.name: python_page(page, "en") for page in PAGES}


def test_each_public_name_has_a_place():
    known = {id(name.value) for name in NAMES}
    for module in PUBLIC:
        public = [*import_module(module).__all__, *(["open"] if module == "mikas" else [])]
        lacking = [
            name
            for name in public
            if id(getattr(import_module(module), name)) not in known and name != "errors"
        ]
        assert lacking == [], module
    for module in ("mikas.errors", "mikas.commands"):
        lacking = [
            name
            for name, each in vars(import_module(module)).items()
            if isinstance(each, type) and each.__module__.startswith(module)
            if id(each) not in known
        ]
        assert lacking == [], module


def test_no_name_has_two_places():
    words = [name.name for name in NAMES]
    assert sorted(words) == sorted(set(words))


@pytest.mark.parametrize("name", NAMES, ids=lambda each: f"{each.module}.{each.name}")
def test_each_name_and_each_member_has_a_docstring_and_is_on_its_page(name: Name, pages):
    page = pages[name.module]
    assert f"## {name.name}\n" in page
    assert name.doc
    for member in (*name.members, *name.fields):
        assert member.doc, member.name
        if name.kind != "error" or name.name == "MikasError":
            assert f"\n| `{member.name}` |" in page
    for method in name.methods:
        assert method.doc, method.name
        assert f"### {name.name}.{method.name}\n" in page


def test_each_field_of_an_error_has_a_meaning_and_no_other_word_has_one():
    used = {
        field
        for each in vars(errors).values()
        if isinstance(each, type) and issubclass(each, mikas.MikasError)
        for field in each.field_names()
    }
    assert used == set(MEANINGS)


def test_what_readers_looked_for_in_vain(pages):
    assert "| `timeout` | `float` | `0.5` | Seconds from the end" in pages["mikas.client"]
    assert "-> Awaitable[dict[str, Reading]]: ..." in pages["mikas"]
    assert "-> AsyncItems[Sample]: ..." in pages["mikas"]
    assert "| `DANGEROUS` | `3` | Writes to CODE" in pages["mikas.commands"]
    assert '| `ECHO` | `"bad-echo"` |' in pages["mikas.testing"]
    assert "- the clock never runs back\n" in pages["mikas.testing"]
    port_busy = pages["mikas.errors"].partition("## PortBusy\n")[2].partition("\n## ")[0]
    assert "*error* of [`NoConnection`](#noconnection)" in port_busy
    assert "> Port {url} is in use by {holder}." in port_busy
    assert "| `holder` | the program that has it" in port_busy


@pytest.mark.parametrize("language", LANGUAGES)
def test_each_link_of_the_reference_leads_to_a_heading(language):
    written = {path_of(page).rpartition("/")[2]: python_page(page, language) for page in PAGES}
    anchors = {path: Document(text).anchors for path, text in written.items()}
    for path, text in written.items():
        for link in Document(text).links:
            if link.path.endswith("protocol.md"):
                continue
            assert link.anchor in anchors[link.path or path], (path, link.target)


def test_the_russian_pages_begin_in_russian():
    assert "Описания взяты из программы" in python_page(PAGES[0], "ru")
