"""The report's section of the mixture, in both languages."""

from __future__ import annotations

import re

from report_harness import found

from drives.drive_rig import Road, Session, Unit, recorded
from mikas.report.from_recording import find_in_recording
from mikas.report.page import render
from mikas.report.sections.mixture import mixture_section


def drive(tmp_path, *parts):
    """Twelve seconds of each part: rpm, throttle, what the meter says."""
    unit, road = [], []
    for number, (rpm, throttle, measured) in enumerate(parts):
        begin = 12.0 * number
        unit += [Unit(begin + at / 4, rpm, aimed=1.0, throttle=throttle) for at in range(48)]
        road += [Road(begin + 2 + at / 10, 0.0, lambda_=measured) for at in range(90)]
    return find_in_recording(recorded(tmp_path / "a.pcapng", Session(unit, road)))


def test_the_section_names_the_cells_that_differ(tmp_path):
    findings = drive(tmp_path, (800, 0, 1.0), (2400, 30, 1.08), (3000, 60, 0.9))
    page = render(findings, "en")
    section = page.split("<h2>Mixture: aimed at and measured</h2>")[1].split("</section>")[0]
    assert "Of 3 cells with enough values, in 1 the measured mixture is leaner" in section
    rows = [re.findall("<td>(.*?)</td>", row) for row in re.findall("<tr>(.*?)</tr>", section)]
    assert rows[1:] == [
        ["500–1100", "0–20", "1.00", "1.00", "0.0 % (0.0 … 0.0)", "90", "as aimed at"],
        ["2200–2800", "20–35", "1.00", "1.08", "+8.0 % (+8.0 … +8.0)", "90", "leaner"],
        ["2800–3500", "50–65", "1.00", "0.90", "−10.0 % (−10.0 … −10.0)", "90", "richer"],
    ]
    russian = mixture_section(findings, "ru").body
    assert "беднее заданной больше чем на 3 %" in russian
    assert "+8,0 % (+8,0 … +8,0)" in russian
    assert not re.search("None|nan|[{}]", russian)


def test_agreement_and_too_few_values_have_their_own_sentences(tmp_path):
    assert (
        "In all cells with enough values (2)"
        in mixture_section(drive(tmp_path, (800, 0, 1.0), (2400, 30, 1.02)), "en").body
    )
    few = find_in_recording(
        recorded(
            tmp_path / "b.pcapng",
            Session(
                [Unit(at / 4, 800, aimed=1.0, throttle=0) for at in range(20)],
                [Road(2 + at / 10, 0.0, lambda_=1.0) for at in range(10)],
            ),
        )
    )
    section = mixture_section(few, "en")
    assert "No cell of speed and load has 30 values" in section.body
    assert "<table>" not in section.body
    assert few.subject.mixture.load == "THR"


def test_without_a_meter_there_is_no_such_section():
    assert mixture_section(found(), "en") is None
