"""`watch` where there is no terminal: how long, how often, by which method, and its gaps."""

from __future__ import annotations

from itertools import pairwise

import pytest
from cli_harness import is_one_short_paragraph, is_russian

from mikas.link.virtual import VirtualLink
from mikas.recording import CaptureReader


def test_a_sample_is_a_line_in_the_numbers_of_the_language(mikas):
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
def test_every_method_gives_samples_of_all_names(mikas, method):
    samples = mikas("watch", "TWAT", "FREQ", "--count", "3", "--method", method, "--json").objects
    assert len(samples) == 3
    assert all(set(s["values"]) == {"TWAT", "FREQ"} and not s["gap"] for s in samples)


@pytest.mark.parametrize("method", ["auto", "stream"])
def test_samples_come_at_the_requested_rate(mikas, method):
    samples = mikas(
        "watch", "TWAT", "--rate", "2", "--count", "5", "--method", method, "--json"
    ).objects
    times = [sample["time"] for sample in samples]
    assert times[-1] - times[0] == pytest.approx(2.0, abs=0.2)


def test_watch_ends_after_its_duration_or_count(mikas):
    samples = mikas("watch", "TWAT", "--duration", "2", "--rate", "4", "--json").objects
    assert 8 <= len(samples) <= 9
    assert samples[-1]["time"] - samples[0]["time"] <= 2.1
    assert len(mikas("watch", "TWAT", "--duration", "3", "--rate", "0.1", "--json").objects) == 1
    assert len(mikas("watch", "TWAT", "--duration", "60", "--count", "2", "--json").objects) == 2


KEY_OFF = "&scenario=key-off"  # the engine runs, then the ignition is switched off for good


def test_ignition_off_is_waited_out_and_every_value_is_null(mikas):
    ran = mikas("watch", "TWAT", "RXX", "--duration", "30", "--rate", "5", "--json", sim=KEY_OFF)
    assert ran.status == 0
    gaps = [sample for sample in ran.objects if sample["gap"]]
    assert gaps
    assert len(gaps) < len(ran.objects)
    for sample in ran.objects:
        nothing = {"TWAT": None, "RXX": None}
        assert (sample["values"] == nothing) is sample["gap"]
    times = [sample["time"] for sample in gaps]
    # A line a try: a reader of the lines sees that time goes on.
    assert max(later - before for before, later in pairwise(times)) < 3
    assert ran.objects[-1]["time"] - ran.objects[0]["time"] >= 29
    assert "ignition off? Waiting; sampling resumes by itself." in ran.err
    is_russian(mikas("watch", "TWAT", "--duration", "30", "--rate", "5", "--lang", "ru").err)


@pytest.mark.parametrize("method", ["stream", "batch"])
def test_how_long_it_was_away_is_the_length_of_the_gap(mikas, tmp_path, method):
    argv = ("TWAT", "--method", method, "--duration", "42")
    argv += ("--rate", "5") if method == "batch" else ()
    ran = mikas("log", "-o", "a.pcapng", *argv, sim=KEY_OFF)
    (gap,) = (note.data for note in CaptureReader(tmp_path / "a.pcapng").notes()
              if note.kind == "gap")  # fmt: skip
    assert gap["ended"] - gap["began"] > 15  # it was off for so long
    assert ran.err.count("Back after ") == 1
    assert f"Back after {gap['ended'] - gap['began']:.0f} s." in ran.err


def test_a_gap_in_plain_lines_is_a_dash(mikas):
    ran = mikas("watch", "TWAT", "--duration", "30", "--rate", "5", sim=KEY_OFF)
    assert any(line.endswith("\t–") for line in ran.lines)
    assert ran.lines[1].split("\t")[1] != "–"


def test_every_tenth_cycle_is_null_in_the_other_nine(mikas):
    argv = ("FREQ", "TWAT/10", "--method", "batch", "--count", "60", "--json")
    samples = [sample["values"] for sample in mikas("watch", *argv).objects]
    assert all(list(values) == ["FREQ", "TWAT"] for values in samples)
    assert all(values["FREQ"] is not None for values in samples)
    assert 5 <= sum(values["TWAT"] is not None for values in samples) <= 8
    plain = mikas("watch", "FREQ", "TWAT/10", "--method", "batch", "--count", "60").lines[1:]
    assert sum(line.endswith("\t–") for line in plain) >= 52


@pytest.mark.parametrize("bad", ["TWAT/0", "TWAT/x", "TWAT/", "TWAT/-1", "NOSUCH/10", "/10"])
def test_a_wrong_name_or_divisor_is_an_error_before_anything_is_sent(mikas, bad, tmp_path):
    ran = mikas("log", "-o", "a.pcapng", bad)
    assert (ran.status, ran.out) == (2, "")
    is_one_short_paragraph(ran.err)
    assert not (tmp_path / "a.pcapng").exists()
    is_russian(mikas("watch", bad, "--lang", "ru").err)


def test_a_derived_channel_comes_without_what_it_is_made_of(mikas):
    samples = mikas("watch", "FUEL_FLOW", "DUTY", "--count", "20", "--json").objects
    assert all(list(sample["values"]) == ["FUEL_FLOW", "DUTY"] for sample in samples)
    assert all(0 < sample["values"]["FUEL_FLOW"] < 20 for sample in samples[1:])
    plain = mikas("watch", "FUEL_FLOW", "--count", "2").lines
    assert plain[0] == "time\tFUEL_FLOW"


def test_another_method_is_found_where_one_is_missing(mikas):
    ran = mikas("watch", "TWAT", "--count", "600", "-v", sim="&missing=stream,list")
    assert ran.status == 0, ran.err
    assert "Method: batch (" in ran.err
    assert "Plan: batch, " in ran.err


def test_what_was_learnt_is_shown_and_forgotten(mikas):
    mikas("watch", "--duration", "10", sim="")
    learnt = mikas("info", "--quick", "--json").object["limits"]["methods"]
    (rates,) = learnt.values()
    assert rates["stream"] > rates["batch"] > 0
    assert "stream " in mikas("info", "--quick").out
    second = mikas("watch", "--count", "5", "-v").err
    assert "Method: stream" in second
    again = mikas("watch", "--count", "5", "-v", "--relearn").err
    assert "Method: " not in again  # it is still measuring
    assert "Testing sampling methods" in again
    is_russian(mikas("info", "--quick", "--lang", "ru").out, wordy=False, names=("batch", "ms"))


def test_a_refused_parameter_is_reported_once(mikas):
    ran = mikas("watch", "0x55", "TWAT", "--count", "30", "--json")
    assert ran.err.count("0x55") == 1
    assert "the other parameters are still read" in ran.err
    is_russian(mikas("watch", "0x55", "TWAT", "--count", "3", "--lang", "ru").err)


def test_an_alarm_is_reported_in_words_and_recorded(mikas, tmp_path):
    (tmp_path / "mine.toml").write_text("[parameter.TWAT.limits]\nwarning_high = 50\n")
    ran = mikas("log", "-o", "a.pcapng", "TWAT", "--count", "5", "--catalog", "mine.toml")
    assert "▲ Coolant temperature" in ran.err
    assert "is above 50 °C: warning." in ran.err
    (note,) = (n for n in CaptureReader(tmp_path / "a.pcapng").notes() if n.kind == "alarm")
    assert note.data["channel"] == "TWAT"


def test_an_alarm_of_the_very_last_sample_is_reported_and_recorded_too(mikas, tmp_path):
    (tmp_path / "mine.toml").write_text("[parameter.TWAT.limits]\nwarning_high = 50\n")
    argv = ("TWAT", "--count", "1", "--catalog", "mine.toml", "--json")
    ran = mikas("log", "-o", "a.pcapng", *argv)
    assert len(ran.objects) == 1
    assert ran.err.count("is above 50 °C: warning.") == 1
    (note,) = (n for n in CaptureReader(tmp_path / "a.pcapng").notes() if n.kind == "alarm")
    assert note.data["channel"] == "TWAT"


@pytest.mark.parametrize("names", [(), ("FREQ", "TWAT/10", "FUEL_FLOW")])
def test_the_price_needs_no_port(mikas, monkeypatch, names):
    monkeypatch.setenv("MIKAS_PORT", "/dev/nosuch")
    prices = mikas("watch", *names, "--price", "--json").object["prices"]
    by_method = {price["method"]: price for price in prices}
    assert list(by_method) == ["single", "batch", "list", "stream"]
    assert by_method["batch"]["sets_per_second"] > by_method["single"]["sets_per_second"]
    for price in prices:
        assert price["sets_per_second"] == pytest.approx(1000 / price["ms"], rel=0.02)
    if names:
        more = by_method["batch"]["one_more"]
        assert more["ms"] == pytest.approx(2.1, abs=0.1)  # a code and a byte, 1.04 ms each
        assert more["sets_per_second"] < by_method["batch"]["sets_per_second"]
    table = mikas("watch", *names, "--price", "--lang", "ru")
    assert (table.status, len(table.lines), table.err) == (0, 5, "")
    is_russian(table.lines[0])
    assert mikas("watch", "NOSUCH", "--price").status == 2


def test_a_parameter_that_the_unit_does_not_know_is_null_and_no_gap(mikas):
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


def test_faults_are_printed_with_their_text_or_as_unknown(mikas):
    assert mikas("faults", sim="").out == "No faults are stored.\n"
    ran = mikas("faults", sim="&faults=13,200")
    assert "Air mass signal low" in ran.out
    assert "unknown fault number" in ran.out
    ran = mikas("faults", "erase", "--yes", "--lang", "ru")
    assert ran.out.endswith("Ошибки сброшены; в памяти их нет.\n")


def test_raw_prints_the_response_or_that_there_is_none(mikas):
    assert mikas("raw", "02").out == "00\n"
    ran = mikas("raw", "99", "--yes")
    assert (ran.status, ran.out) == (0, "")
    assert "No response" in ran.err


def test_info_in_text_names_model_and_missing_commands(mikas):
    ran = mikas("info", "--lang", "ru", sim="&missing=stream")
    assert "Микас 7.1 (0A)" in ran.out
    assert "71 циклический поток" in ran.out
    assert "блок не сообщает" in mikas("info", "--lang", "ru", sim="&missing=count").out


def test_without_an_adapter_ports_points_to_the_demo(mikas, monkeypatch):
    monkeypatch.setattr("mikas.cli.commands.ports.find_ports", list)
    ran = mikas("ports")
    assert (ran.status, ran.out) == (0, "")
    assert "mikas demo" in ran.err


def test_a_stream_that_the_unit_does_not_end_is_reported(mikas, monkeypatch):
    """D12: over TCP there is no break, and the run has no next exchange."""
    words = ("watch", "FREQ", "--method", "stream", "--count", "5")
    assert "stream" not in mikas(*words, sim="&stream_end=break").err
    monkeypatch.setattr(
        VirtualLink, "send_break", lambda link, seconds: link.gather(link.now() + seconds)
    )
    ran = mikas(*words, sim="&stream_end=break")
    assert (ran.status, len(ran.out.splitlines())) == (0, 6)
    assert ran.err.count("a stream that the unit does not end") == 1
