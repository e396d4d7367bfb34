"""The figures of the protocol's page: the product's settings (from the code) and §5 (computed)."""

from __future__ import annotations

import re

import pytest
from tools.docs.pages import DOCS, LANGUAGES, RUSSIAN, document

from mikas.catalog import shipped
from mikas.client.connecting import ConnectionOptions
from mikas.client.limits import STARTING_LIST
from mikas.commands import LARGEST_BLOCK
from mikas.framing import Decoder, encode
from mikas.tester import Timing
from mikas.tester.line_sync import _BREAK, _INTERRUPTIONS
from mikas.tester.stream import _STANDING_ENGINE
from mikas.virtual.quirks import EcuQuirks

BYTE = 10 / 9600  # s, §1
CODES = [
    (code, size) for code, size in shipped().codes if shipped().by_code(code)[0].source == "§4"
]
HOME = {"en": DOCS, "ru": RUSSIAN}


def written(language):
    """The page with thousands and decimals as code writes them."""
    page = document(HOME[language] / "protocol.md").text
    page = re.sub(r"(?<=\d)[, ](?=\d{3}\b)", "", page)  # 4,096; 65 536
    return re.sub(r"(?<=\d),(?=\d)", ".", page) if language == "ru" else page


def settings(language):
    """The blocks that are about mikas only, as one line."""
    lines = [line.strip() for line in written(language).splitlines()]
    return " ".join(line.removeprefix("> ") for line in lines if line.startswith(">"))


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_settings_of_this_product_are_those_of_the_code(language):
    timing, quirks, options = Timing(), EcuQuirks(), ConnectionOptions()
    ms, s = {"en": ("ms", "s"), "ru": ("мс", "с")}[language]
    endless = timing.response_timeout + 2 * 1100 * BYTE + 5 * timing.inter_byte_timeout
    assert (options.timeout, options.inter_byte_timeout, options.retries) == (
        timing.response_timeout, timing.inter_byte_timeout, 2
    )  # fmt: skip
    said = settings(language)
    for figure in (
        f"{timing.response_timeout * 1000:g} {ms}",
        f"**{timing.inter_byte_timeout * 1000:g} {ms}**",
        f"{timing.idle_time * 1000:g} {ms}", f"{timing.stream_gap * 1000:g} {ms}",
        f"{quirks.turn_round * 1000:g} {ms}", f"{endless:.1f} {s}", f"{quirks.stream_load:g}",
        f"{STARTING_LIST} ", f"{LARGEST_BLOCK} ", f"{Decoder().limit} ",
    ):  # fmt: skip
        assert re.search(rf"(?<![\d.]){re.escape(figure)}", said), figure


@pytest.mark.parametrize(
    ("language", "said"),
    [
        ("en", "`01` is tried {count} times, then a break of {brk:g} ms"),
        ("ru", "`01` посылается до {count} раз, затем break на {brk:g} мс"),
    ],
)
def test_how_a_stream_is_ended(language, said):
    count = {"en": {6: "six"}, "ru": {6: "шести"}}[language][_INTERRUPTIONS]
    assert said.format(count=count, brk=1000 * _BREAK) in settings(language)


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_strokes_of_an_engine(language):
    page = written(language).partition('<a id="d15"></a>')[2].partition('<a id="d16"></a>')[0]
    for rpm, figure in ((850, "7.1"), (5200, "43")):  # a response in two turns
        assert f"{rpm / 2 / 60:.2g}" == figure
        assert re.search(rf"\b{rpm}\b.*?(?<![\d.]){re.escape(figure)}(?![\d])", page, re.DOTALL)
    second = {"en": "s", "ru": "с"}[language]
    assert re.search(rf" {_STANDING_ENGINE:g} {second}\b", page)


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_arithmetic_of_section_5(language):
    page = written(language).partition('<a id="s5"></a>')[2].partition('<a id="s6"></a>')[0]
    requests = sum(len(encode(bytes([0x61, code]))) for code, _ in CODES)
    responses = sum(size + 2 for _, size in CODES)
    data = sum(size for _, size in CODES)
    batch = len(encode(bytes([0x61, *(code for code, _ in CODES)])))
    assert (len(CODES), data) == (21, 25)
    assert f" {requests + responses} " in page
    assert f" {batch} + {data + 2} " in page
    assert f" {len(encode(bytes([0x63])))} + {data + 2} " in page
    delay = 0.002
    times = [
        (requests + responses) * BYTE + len(CODES) * delay,
        (batch + data + 2) * BYTE + delay,
        (3 + data + 2) * BYTE + delay,
        (data + 2) * BYTE,
    ]
    figures = re.findall(r"\d+(?:\.\d+)?", page.partition("d = 2")[2])
    said = [float(each) for each in figures[:8]]
    assert [round(1000 * each) for each in times] == pytest.approx(said[:4], abs=1)
    assert [1 / each for each in times] == pytest.approx(said[4:], rel=0.02)
    blocks = -(-65536 // LARGEST_BLOCK)
    assert f" {blocks} · (6 + 4) + 65536 " in page
    assert re.search(r" (\d+) [sс]\.\n", page)[1] == str(
        round((blocks * 10 + 65536 * (1 + 2 / 256)) * BYTE + blocks * delay)
    )
