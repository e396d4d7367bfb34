"""What is made from the program: all of the catalog, and frames that the decoder takes."""

from __future__ import annotations

import re

import pytest
from tools.docs.generated import catalog_pages, command_pages, frames, help_pages
from tools.docs.generated.tables import interval, table
from tools.docs.markdown import Document
from tools.docs.pages import LANGUAGES

from mikas.catalog import shipped
from mikas.commands import COMMANDS_BY_CODE
from mikas.framing import Decoder, Frame

CATALOG = shipped()


@pytest.mark.parametrize("language", LANGUAGES)
def test_nothing_of_the_catalog_is_missing(language):
    parameters = catalog_pages.parameters(CATALOG, language)
    faults = catalog_pages.faults(CATALOG, language)
    channels = catalog_pages.channels(CATALOG, language)
    commands = command_pages.commands(CATALOG, language)
    assert all(
        f"| `{each.code:02X}` | `{each.name}` |" in parameters for each in CATALOG.parameters
    )
    assert all(each.reason.to(language) in parameters for each in CATALOG.errata.values())
    assert all(
        f"| **{code}** | {fault.text.to(language)} |" in faults
        for code, fault in CATALOG.faults.items()
    )
    assert all(f"| `{name}` |" in channels for name in CATALOG.derived)
    assert all(f"| `{code:02X}` |" in commands for code in COMMANDS_BY_CODE)


def test_cells_stay_cells_and_numbers_are_of_the_language():
    made = table("ru", ("a|b", "в|г"), [("x | y", "1\n2")])
    assert made == "| в | г |\n| --- | --- |\n| x \\| y | 1 2 |\n"
    assert interval((-1.5, 20), "ru") == "−1,5 … 20"
    assert interval(None, "en") == ""


def lanes(drawing):
    """The bytes of each row of a drawing, from left to right."""
    found = {}
    for y, value in re.findall(r'y="([\d.]+)" class="b"[^>]*>(\w\w)<', drawing):
        found.setdefault(float(y), []).append(int(value, 16))
    return [bytes(row) for row in found.values()]


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_drawings_show_whole_frames(language):
    drawn = dict(frames.drawings(CATALOG, language))
    assert lanes(drawn["frame-exchange"]) == [b"\x61\x1a\x85\x0d", b"\x7e\x82\x0d"]
    body, wire, answered, on_the_line = lanes(drawn["frame-stuffing"])
    for plain, whole in ((body, wire), (answered, on_the_line)):
        (frame,) = Decoder().feed(whole)
        assert isinstance(frame, Frame)
        assert frame.body == plain
    assert b"\x40\x00" in wire
    assert b"\x40\xcd" in on_the_line
    for name in ("frame-echo", "frame-stream"):
        events = Decoder().feed(b"".join(lanes(drawn[name])))
        assert len(events) > 2
        assert all(isinstance(each, Frame) for each in events)


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_help_has_every_command_and_common_options_once(language):
    page = help_pages.help_page(language)
    titles = [each.words for each in Document(page).headings]
    assert {"mikas", "mikas read", "mikas mem dump", "mikas list set"} <= set(titles)
    assert page.count("--interpretation [corrected|literal|alternative|family]") == 1
