"""The page: whole, closed to the outside, safe for anybody's words, in both languages."""

from __future__ import annotations

import re
from base64 import b64encode
from dataclasses import replace
from hashlib import sha256
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from report_harness import START, found, rows

from mikas.catalog import load, shipped
from mikas.errors import EchoOnly
from mikas.i18n import Text
from mikas.report import page
from mikas.report.findings import find
from mikas.report.subject import ReportedUnit
from mikas.sampling.events import Gap

_EMPTY = {"meta", "link", "br", "img"}


class Parsed(HTMLParser):
    """A page taken apart; unbalanced tags are an error."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.texts: list[str] = []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in _EMPTY:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data) -> None:
        if "style" not in self.open:
            self.texts.append(data)

    @property
    def printed(self) -> str:
        return re.sub("[ \n]+", " ", " ".join(self.texts))


def every_kind():
    """One of each: inside, off, unjudged, faults of each sort, gaps."""
    gap = Gap(START + 15, START + 10, START + 15, Text("no echo", "нет эха"))
    return found(
        rows(60, JAIR=11.0, UACC=12.9),
        faults=(12, 13, 53, 99),
        interruptions=(gap, Gap(START + 20, START + 20, None), gap, gap, gap),
        sessions=2,
        damaged=3,
        port="/dev/ttyUSB0",
        adapter="CH340",
        method="stream",
        echo=True,
        errors=2,
    )


def idle_never():
    return found(rows(TWAT=40), faults=None)


def nothing():
    findings = found(rows(0), faults=None, file="", date=None)
    return replace(findings, subject=replace(findings.subject, unit=None))


@pytest.mark.parametrize("language", ["en", "ru"])
@pytest.mark.parametrize("make", [found, every_kind, idle_never, nothing])
def test_a_whole_page_that_needs_nothing_from_elsewhere(make, language) -> None:
    text = page.render(make(), language)
    parsed = Parsed(text)
    tags = [tag for tag, _ in parsed.tags]
    assert not {"script", "link", "img", "iframe", "object", "form", "a", "base"} & set(tags)
    for _, attributes in parsed.tags:
        assert not {"style", "src", "href", "onload"} & set(attributes)
    assert "url(" not in text
    assert "@import" not in text
    assert tags.count("style") == tags.count("main") == 1
    assert ("html", {"lang": language}) in parsed.tags
    assert not re.search(r"\bNone\b|\bnan\b|\binf\b|Markup|object at|[{}]", parsed.printed)


@pytest.mark.parametrize(
    ("language", "printed"), [("en", "virtual ECU · "), ("ru", "виртуальный блок · ")]
)
def test_a_virtual_unit_is_called_so_in_the_page_s_language(language, printed) -> None:
    text = page.render(found(adapter="virtual ECU", port="sim:"), language)
    assert printed in Parsed(text).printed


def test_a_virtual_car_is_named_in_words() -> None:
    url = "sim:?scenario=warm-idle&seed=1"
    text = page.render(found(port=url, adapter="virtual ECU"), "ru")
    assert "scenario=" not in text
    assert "виртуальный блок · " in text
    assert "виртуальный автомобиль" in page.render(found(port="sim:?scenario=/home/x.toml"), "ru")
    assert "/dev/ttyUSB0" in page.render(found(port="/dev/ttyUSB0"), "en")


def test_its_policy_lets_in_the_style_it_carries_and_nothing_else() -> None:
    text = page.render(found(), "en")
    style = re.search(r"<style>(.*?)</style>", text, re.DOTALL)
    assert style is not None
    digest = b64encode(sha256(style[1].encode()).digest()).decode()
    (policy,) = [
        attributes["content"]
        for tag, attributes in Parsed(text).tags
        if tag == "meta" and attributes.get("http-equiv") == "Content-Security-Policy"
    ]
    assert policy == page.policy()
    assert "default-src 'none'" in policy
    assert f"style-src 'sha256-{digest}'" in policy
    assert "unsafe" not in policy


def test_a_russian_page_has_no_english_word() -> None:
    printed = Parsed(page.render(every_kind(), "ru")).printed
    printed = printed.replace(shipped().version, "")  # a checksum
    for name in (*(p.name for p in shipped().parameters), *shipped().derived):
        printed = re.sub(rf"\b{name}\b", "", printed)
    left = set(re.findall(r"[A-Za-z]{3,}", printed)) - {"drive", "pcapng", "dev", "ttyUSB", "mikas"}
    assert left == set()


def test_the_page_says_outcome_faults_unit_and_values() -> None:
    printed = Parsed(page.render(every_kind(), "en")).printed
    for part in (
        "Attention needed",
        "3 faults are stored: 13, 53, 99;",
        "Mikas 7.1",
        "МИКАС 7.1 · 241.3763",
        "09.05.2026 12:30",
        "Air mass signal low",
        "Check: Connector and wiring of the air mass meter",
        "the text is from one source · measured: Air flow 11.0\N{NO-BREAK SPACE}kg/h (perhaps",
        "text unconfirmed: commonly printed, no source known",
        "unknown fault number",
        "a message, not a fault; the text is confirmed by two sources",
        "Air flow JAIR 11.0\N{NO-BREAK SPACE}kg/h 11.0 13 … 16 not rated Not rated: the sensor's",
        "circuit is faulty (fault 13), the unit may use a substitute value.",
        "12.9\N{NO-BREAK SPACE}V 12.9 13.5 … 14.5 low 0\N{NO-BREAK SPACE}% of the readings",
        "a stream from the unit (71)",
        "CH340 · /dev/ttyUSB0",
        "5: 0:10–0:15 (no echo); 0:20–…; 0:10–0:15 (no echo); 2 more",
        "600, 10.0 readings/s",
        "The file holds 2 sessions",
        shipped().version,
    ):
        assert part in printed, part


def test_the_numbers_are_those_that_were_measured() -> None:
    parsed = Parsed(page.render(found(rows(UACC=13.84, TAIR=-7)), "ru"))
    assert "13,8\N{NO-BREAK SPACE}В" in parsed.printed
    assert "−7\N{NO-BREAK SPACE}°C" in parsed.printed


def test_rcok_has_its_readings_beside_each_other() -> None:
    both = found(rows(RCOK=-0.5, RCOD=-0.25))
    shown = Parsed(page.render(both, "en")).printed
    assert re.search(r"RCOK \(alternative 0\.000, family 1\.000\)\s*−0\.500", shown)
    assert re.search(r"RCOD \(alternative 0\.250\)\s*−0\.250", shown)
    shown = Parsed(page.render(both, "ru")).printed
    assert "(иначе 0,000, как у родственных 1,000)" in shown


def test_anybody_s_words_stay_words(tmp_path: Path) -> None:
    evil = '<script>alert("1")</script>&\'"><svg onload=x>'
    own = tmp_path / "own.toml"
    own.write_text(
        "[parameter.TWAT]\ntext.en = '''E'''\nunit = '''E'''\n[parameter.TWAT.meaning]\n"
        "high = '''E'''\n[fault.13]\ntext = '''E'''\ncheck = '''E'''\n[model.0x0A]\n"
        "text = '''E'''\n".replace("E", evil.replace("'''", "")),
        "utf-8",
    )
    catalog = load(own)
    findings = found(rows(TWAT=99), file=f"{evil}.pcapng", port=evil, adapter=evil)
    subject = replace(
        findings.subject,
        catalog=catalog,
        unit=ReportedUnit(catalog.model(0x0A), (evil,), (evil,)),
        faults=(catalog.fault(13),),
        notes=(evil,),
    )
    from report_harness import measured

    text = page.render(find(subject, measured(rows(TWAT=99), catalog=catalog)), "en")
    parsed = Parsed(text)
    assert "script" not in {tag for tag, _ in parsed.tags}
    assert all("onload" not in attributes for _, attributes in parsed.tags)
    assert parsed.printed.count(evil) >= 10


def drawings(text: str) -> list[ET.Element]:
    found_ = re.findall(r'<svg class="chart".*?</svg>', text, re.DOTALL)
    return [ET.fromstring(each) for each in found_]


def of_class(drawing: ET.Element, name: str) -> list[ET.Element]:
    return [each for each in drawing.iter() if each.get("class") == name]


def test_three_charts_what_is_off_first() -> None:
    text = page.render(found(rows(UACC=12.9)), "en")
    titles = re.findall(r"<figcaption>(.*?)</figcaption>", text)
    assert titles == ["Battery voltage, V", "Crankshaft speed, rpm", "Air flow, kg/h"]
    assert len(drawings(text)) == 3
    for drawing in drawings(text):
        assert drawing.get("role") == "img"
        assert drawing.get("aria-label")
        (band,) = of_class(drawing, "band")
        assert float(band.get("height")) > 0
        (idle,) = of_class(drawing, "idle")
        assert 0 < float(idle.get("width")) < 268


def points(drawing: ET.Element) -> list[list[tuple[float, float]]]:
    (course,) = of_class(drawing, "course")
    runs = [run for run in (course.get("d") or "").split("M") if run]
    return [
        [tuple(map(float, pair.split())) for pair in re.findall(r"[\d.]+ [\d.]+", run)]
        for run in runs
    ]


def test_a_spike_is_drawn_and_a_gap_is_one() -> None:
    def spike(times):
        return np.where(times == 30, 5000, 840)

    gap = Gap(START + 50, START + 40, START + 50, Text("gap", "пропуск"))

    def lost(times):
        return np.where((times >= 40) & (times < 50), np.nan, spike(times))

    text = page.render(found(rows(60, FREQ=lost), interruptions=(gap,)), "en")
    drawing = drawings(text)[0]
    before, after = points(drawing)
    assert min(y for _, y in before) < 30 < 140 < max(y for _, y in before)
    assert before[-1][0] < after[0][0]
    (pause,) = of_class(drawing, "pause")
    at, wide = float(pause.get("x")), float(pause.get("width"))
    assert abs(at - before[-1][0]) < 3
    assert abs(at + wide - after[0][0]) < 3


@pytest.mark.parametrize("language", ["en", "ru"])
def test_the_reason_of_a_gap_has_no_bytes_and_no_advice(language) -> None:
    error = EchoOnly(request=b"\x01\xff\x0d", received=b"\x01\xff\x0d")
    gap = Gap(START + 50, START + 40, START + 50, error.text)
    text = page.render(found(rows(60), interruptions=(gap,)), language)
    assert f"0:50 ({error.reason.to(language)})" in text
    assert "FF 0D" not in text


def test_a_slow_parameter_is_one_line() -> None:
    def slow(times):
        return np.where(np.arange(times.size) % 50 == 0, 88, np.nan)

    text = page.render(found(rows(60, TWAT=slow, JAIR=None, INJ=None)), "en")
    (run,) = points(drawings(text)[1])
    assert len(run) == 12


def test_one_single_value_is_a_dot() -> None:
    text = page.render(found(rows(0.1)), "en")
    for drawing in drawings(text):
        (course,) = of_class(drawing, "course")
        assert (course.get("d") or "").endswith("h0.5")


def test_the_same_findings_make_the_same_page() -> None:
    assert page.render(every_kind(), "ru") == page.render(every_kind(), "ru")
