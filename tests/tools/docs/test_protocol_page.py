"""The protocol's page: its anchors, evidence, worked bytes, lengths; citations of it anywhere."""

from __future__ import annotations

import json
import re
from collections import Counter
from pathlib import PurePosixPath

import pytest
from tools.docs.assembling import assemble
from tools.docs.checking import citations
from tools.docs.checking.citations import CITED, anchor_of
from tools.docs.generated import protocol_page
from tools.docs.pages import DOCS, LANGUAGES, ROOT, RUSSIAN, Page, document

from mikas import commands as c
from mikas.catalog import shipped
from mikas.framing import Decoder, Frame, encode

HOME = {"en": DOCS, "ru": RUSSIAN}
CODES = sorted(c.COMMANDS_BY_CODE)
CLAUSES = {"s1", "s2", "s2-1", "s2-2", "s2-3", "s2-4", "s3", "s3-1", "s3-2", "s3-3", "s3-4",
           "s3-5", "s4", "s4-1", "s4-2", "s5"}  # fmt: skip
DECISIONS = {f"d{number}" for number in range(1, 18)}
ERRATA = {f"e{number}" for number in range(1, 5)}
COMMANDS = {f"cmd-{code:02x}" for code in CODES}
PARAMETERS = {f"p-{each.name.lower()}" for each in shipped().parameters if each.source == "§4"}
SUPPORTED = CLAUSES | DECISIONS | ERRATA | COMMANDS | PARAMETERS

SOURCES = ("src", "tests", "tools", "docs", "examples", "conformance", "fuzz", "bench", "web/src")
SUFFIXES = {".c", ".h", ".lua", ".md", ".py", ".svelte", ".toml", ".ts"}
BUILT = re.compile(r"/(node_modules|dashboard/page|__pycache__|corpus|\.[a-z_]+)/")
MADE_UP = {"tests/catalog/test_wrong_catalogs.py": {"E9"}}
OWN = "tests/tools/docs/test_protocol_page.py"


def text(language):
    return document(HOME[language] / "protocol.md").text


def test_every_clause_command_parameter_decision_and_erratum_has_one_anchor():
    for language in LANGUAGES:
        found = Counter(re.findall(r'<a id="([^"]+)"></a>', text(language)))
        assert {anchor for anchor, times in found.items() if times > 1} == set()
        assert set(found) >= SUPPORTED
        assert {anchor for anchor in found if re.fullmatch(r"[sde][\d-]+", anchor)} == (
            CLAUSES | DECISIONS | ERRATA | {"s6", "s7"}
        )
    english, russian = (re.findall(r'<a id="([^"]+)"', text(each)) for each in LANGUAGES)
    assert english == russian


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_anchor_is_at_its_own_words(language):
    place = r'<a id="([sde]\d[\d-]*)"></a>(?:<a [^>]*></a>)?\W*([\w.]+)'
    for anchor, words in re.findall(place, text(language)):
        assert words.lower().replace(".", "-") == anchor.removeprefix("s")


@pytest.mark.parametrize("language", LANGUAGES)
def test_everything_has_its_evidence_once(language):
    table = text(language).partition('<a id="s6"></a>')[2].partition('<a id="s7"></a>')[0]
    rows = [line.split(" | ") for line in table.splitlines() if line.startswith("| [")]
    named = Counter(anchor for row in rows for anchor in re.findall(r"\(#([\w-]+)\)", row[0]))
    assert set(named) == SUPPORTED
    assert max(named.values()) == 1
    assert all(len(row) == 4 for row in rows)


def sources():
    for folder in SOURCES:
        for path in sorted((ROOT / folder).rglob("*")):
            name = path.relative_to(ROOT).as_posix()
            cites = path.suffix in SUFFIXES or path.name == "schema.json"
            if cites and not BUILT.search(f"/{name}") and name != OWN:
                yield name, path


def test_every_citation_in_code_tests_and_documents_is_of_a_clause_that_exists():
    known, seen = citations.anchors(), 0
    for name, path in sources():
        for cited in CITED.finditer(path.read_text("utf-8")):
            seen += 1
            assert anchor_of(cited) in known or cited[0] in MADE_UP.get(name, ()), name
    assert seen > 1000


def test_a_byte_is_no_citation():
    found = [
        each[0] for each in CITED.finditer("E8 03, `N E1 E0`: D13, §2.1 and (E3), #d4, D0, 0xE2")
    ]
    assert found == ["D13", "§2.1", "E3"]


ROW = re.compile(r"^\| [^|]*\| [^|]+ \| `([^`]+)` \| `([^`]+)` \| ", re.MULTILINE)


def section(language, begin, end):
    return text(language).partition(f'<a id="{begin}"></a>')[2].partition(f'<a id="{end}"></a>')[0]


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_worked_bytes_show_every_command_and_are_whole_messages(language):
    shown = section(language, "s3-5", "s4")
    anchors = re.findall(r'<a id="bytes-([\da-f]{2})">', shown)
    assert sorted(anchors) == [f"{code:02x}" for code in CODES]
    rows = ROW.findall(shown)
    assert len(rows) > 2 * len(CODES) - 2
    for body, wire in rows:
        (frame,) = Decoder().feed(bytes.fromhex(wire))
        assert isinstance(frame, Frame)
        assert frame.body == bytes.fromhex(body)
        assert not frame.raw_checksum


@pytest.mark.parametrize("language", LANGUAGES)
def test_what_is_not_marked_as_made_here_is_a_vector(language):
    vectors = json.loads((ROOT / "conformance/exchanges.json").read_text("utf-8"))
    known = {each[f"{end}_wire"] for each in vectors for end in ("request", "answer")}
    lines = section(language, "s3-5", "s4").splitlines()
    made = {line for line in lines if protocol_page.MADE in line.partition(" | ")[0]}
    wires = [found[2] for line in lines if line not in made and (found := ROW.match(line))]
    assert wires
    assert set(wires) <= known
    streams = {code for code in CODES if c.COMMANDS_BY_CODE[code].STREAM}
    requests = [line for line in made if "#cmd" in line]
    assert {int(ROW.match(line)[1][:2], 16) for line in requests} == streams


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_values_of_section_4_are_worked_for_every_parameter(language):
    shown = section(language, "s4-1", "s4-2")
    assert re.findall(r"^\| \[([A-Z]+)\]", shown, re.MULTILINE) == [
        each.name for each in shipped().parameters if each.source == "§4"
    ]
    assert ("14.2 V" if language == "en" else "14,2 В") in shown


def test_the_lengths_of_the_page_are_those_of_the_codec():
    data = b"\x0d" * 255
    bodies = [b"", b"\x01", b"\x26\x0d\x0d\xff" + data, b"\x61" + data, b"\x0d\x0d\xff" + data,
              b"\xff" + b"\x0d\xe0" * 255, b"\x0d\x0d" * 255]  # fmt: skip
    for language in LANGUAGES:
        rows = re.findall(r"\| (\d+) \| (\d+) \|$", section(language, "s2-4", "s3"), re.MULTILINE)
        assert [(int(body), int(wire)) for body, wire in rows] == [
            (len(body), most(body)) for body in bodies
        ]


def most(body):
    """Bytes on the line at most: with some 0D as 40, so that the checksum is stuffed as well."""
    mixed = (body.replace(b"\x0d", b"\x40", count) for count in range(body.count(b"\x0d") + 1))
    return max(len(encode(each)) for each in mixed)


@pytest.mark.parametrize("language", LANGUAGES)
def test_what_the_page_links_to_is_published_beside_it(tmp_path, language):
    page = Page("protocol.md", language, HOME[language] / "protocol.md")
    assemble({page.path: page}, tmp_path)
    links = re.findall(r"\]\(([^)#]+)\)", (tmp_path / page.path).read_text("utf-8"))
    copied = {each for each in links if not each.startswith("https:")}
    conformance = {path.name for path in (ROOT / "conformance").iterdir() if path.is_file()}
    examples = {path.name for path in (ROOT / "examples/c").iterdir()}
    names = [*conformance - {"README.md"}, *examples, "CC-BY-4.0.txt"]
    assert {PurePosixPath(each).name for each in copied if not each.endswith(".svg")} == set(names)
    for each in copied:
        assert (tmp_path / each).is_file()


def test_a_citation_that_is_no_link_is_reported(tmp_path, monkeypatch):
    ours = PurePosixPath("docs/ours.md")
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs/protocol.md").write_text('<a id="d13"></a>**D13 x.** D13\n', "utf-8")
    (tmp_path / "docs/ours.md").write_text(
        "[D13](protocol.md#d13) D13 `D13`\n[D13](protocol.md) D99\n", "utf-8"
    )
    monkeypatch.setattr("tools.docs.pages.ROOT", tmp_path)
    document.cache_clear()
    try:
        assert [(each.line, each.text) for each in citations.findings(ours)] == [
            (1, "D13: no link to protocol.md#d13"),
            (2, "D13: no link to protocol.md#d13"),
            (2, "D99: not in the protocol"),
        ]
        own = citations.findings(PurePosixPath("docs/protocol.md"))
        assert [each.text for each in own] == ["D13: no link to #d13"]
    finally:
        document.cache_clear()
