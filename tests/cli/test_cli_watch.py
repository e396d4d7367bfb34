"""`watch` where there is no terminal: how long, how often, by which method, and its gaps."""

from __future__ import annotations

import pytest


def test_plain_lines(mikas):
    ran = mikas("watch", "TWAT", "RXX", "--count", "2")
    head, *rows = ran.lines
    assert head == "time\tTWAT\tRXX"
    assert len(rows) == 2
    assert all(row.split("\t")[2] == "yes" for row in rows)
    russian = mikas("watch", "UACC", "--count", "1", "--lang", "ru").lines
    assert russian[0] == "время\tUACC"
    assert "," in russian[1].split("\t")[1]


def test_all_parameters_when_none_is_named(mikas):
    assert mikas("watch", "--count", "1").lines[0].count("\t") >= 23


@pytest.mark.parametrize("method", ["auto", "single", "batch", "list", "stream"]
                         + [f"stroke{n}" for n in range(5)])  # fmt: skip
def test_every_method(mikas, method):
    samples = mikas("watch", "TWAT", "FREQ", "--count", "3", "--method", method, "--json").objects
    assert len(samples) == 3
    assert all(set(s["values"]) == {"TWAT", "FREQ"} and not s["gap"] for s in samples)


@pytest.mark.parametrize("method", ["auto", "stream"])
def test_the_rate(mikas, method):
    samples = mikas(
        "watch", "TWAT", "--rate", "2", "--count", "5", "--method", method, "--json"
    ).objects
    times = [sample["time"] for sample in samples]
    assert times[-1] - times[0] == pytest.approx(2.0, abs=0.2)


def test_the_duration(mikas):
    samples = mikas("watch", "TWAT", "--duration", "2", "--rate", "4", "--json").objects
    assert 8 <= len(samples) <= 9
    assert samples[-1]["time"] - samples[0]["time"] <= 2.1
    assert len(mikas("watch", "TWAT", "--duration", "3", "--rate", "0.1", "--json").objects) == 1
    assert len(mikas("watch", "TWAT", "--duration", "60", "--count", "2", "--json").objects) == 2


def test_a_gap_is_null(mikas):
    samples = mikas(
        "watch",
        "TWAT",
        "RXX",
        "--count",
        "60",
        "--retries",
        "0",
        "--json",
        sim="&damaged=0.2&seed=5",
    ).objects
    gaps = [sample for sample in samples if sample["gap"]]
    assert gaps
    assert len(gaps) < 60
    for sample in samples:
        nothing = {"TWAT": None, "RXX": None}
        assert (sample["values"] == nothing) is sample["gap"]


def test_a_gap_in_plain_lines_is_a_dash(mikas):
    ran = mikas("watch", "TWAT", "--count", "60", "--retries", "0", sim="&damaged=0.2&seed=5")
    assert any(line.endswith("\t–") for line in ran.lines)


def test_a_parameter_that_the_unit_does_not_know(mikas):
    sample = mikas("watch", "0x55", "TWAT", "--count", "1", "--json").object
    assert sample["values"]["0x55"] is None
    assert sample["values"]["TWAT"] is not None
    assert sample["gap"] is False
    assert mikas("watch", "0x55", "TWAT", "--count", "1").lines[1].split("\t")[1] == "–"


def test_the_engine_stands_and_there_are_no_strokes(mikas):
    samples = mikas(
        "watch",
        "FREQ",
        "--method",
        "stroke0",
        "--duration",
        "60",
        "--json",
        sim="&scenario=key-off",
    ).objects
    assert samples[-1]["time"] <= 75


def test_read_in_text(mikas):
    ran = mikas("read", "TWAT", "RXX")
    assert [line.split("\t")[0] for line in ran.lines] == ["name", "TWAT", "RXX"]
    assert mikas("read", "UACC", "--lang", "ru").lines[1].split("\t")[1].startswith("14,")
    assert "80 … 95" in ran.out


def test_faults_in_text(mikas):
    assert mikas("faults", sim="").out == "No faults are stored.\n"
    ran = mikas("faults", sim="&faults=13,200")
    assert "Air mass signal low" in ran.out
    assert "what this number means is not known" in ran.out
    ran = mikas("faults", "erase", "--yes", "--lang", "ru")
    assert ran.out.endswith("Стёрто; ошибок нет.\n")


def test_raw_in_text(mikas):
    assert mikas("raw", "02").out == "00\n"
    ran = mikas("raw", "99", "--yes")
    assert (ran.status, ran.out) == (0, "")
    assert "Silence" in ran.err


def test_info_in_text(mikas):
    ran = mikas("info", "--lang", "ru", sim="&missing=stream")
    assert "Микас 7.1 (0A)" in ran.out
    assert "71 циклический поток" in ran.out
    assert "блок не сообщает" in mikas("info", "--lang", "ru", sim="&missing=count").out


def test_no_adapters(mikas, monkeypatch):
    monkeypatch.setattr("mikas.cli.commands.ports.find_ports", list)
    ran = mikas("ports")
    assert (ran.status, ran.out) == (0, "")
    assert "mikas demo" in ran.err
