"""`mikas doctor --other-units`: what it prints, and what its capture shows afterwards."""

from __future__ import annotations

import pytest


def test_another_unit_is_named_in_both_languages_and_as_json(mikas):
    ran = mikas("doctor", "--other-units", sim="&protocol=kwp2000")
    assert ran.status == 3  # no Mikas answers
    marks = [line for line in ran.out.splitlines() if line.startswith("✓ KWP2000")]
    assert len(marks) == 2
    assert all("Mikas 7.6, 10.3, 11 or 12" in line for line in marks)
    russian = mikas("doctor", "--other-units", "--lang", "ru", sim="&protocol=kwp2000")
    assert russian.out.count("✓ KWP2000, ") == 2
    steps = mikas("doctor", "--other-units", "--json", sim="&protocol=kwp2000").object["steps"]
    assert [(step["name"], step["ok"]) for step in steps[-5:]] == [
        ("ecu", False), ("unasked", None), ("other-baud", None), ("kwp2000-fast", True),
        ("kwp2000-slow", True),
    ]  # fmt: skip


def test_without_the_option_nothing_is_woken_up_and_it_is_advised(mikas):
    ran = mikas("doctor", sim="&protocol=kwp2000")
    assert ran.status == 3
    assert "KWP2000" not in ran.out
    assert "`mikas doctor --other-units`" in ran.out
    assert "`mikas doctor --other-units`" in mikas("read", sim="&protocol=kwp2000").err
    with_it = mikas("doctor", "--other-units", sim="&protocol=kwp2000")
    assert "--other-units" not in with_it.out


def test_with_a_mikas_nothing_is_looked_for(mikas):
    ran = mikas("doctor", "--other-units")
    assert ran.status == 0
    assert "no other kind of unit was looked for" in ran.err
    assert "KWP2000" not in ran.out


@pytest.mark.parametrize("sim", ["&protocol=kwp2000", "&baud=19200&adapter_baud=9600"])
def test_its_capture_shows_other_rates_as_bytes_and_not_as_damage(mikas, sim):
    ran = mikas("doctor", "--other-units", "--capture", "x.pcapng", sim=sim)
    assert "Recording stopped" not in ran.err
    lines = mikas("decode", "x.pcapng", "--json").objects
    kinds = {line["type"] for line in lines}
    assert kinds == {"frame", "bytes"}
    sent = [
        line["data"] for line in lines
        if line["type"] == "bytes" and line["direction"] == "sent" and line["baud"] == 10_400
    ]  # fmt: skip
    assert "8110F18103" in sent
    assert {line["baud"] for line in lines if line["type"] == "bytes"} >= {4800, 10_400}
    text = mikas("decode", "x.pcapng").out
    assert "(10400 baud)" in text
    assert "wrong checksum" not in text
    assert "unfinished" not in text
