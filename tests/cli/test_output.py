"""`--json`: the keys of each command are those of docs/reference/cli.md, values its kinds."""

from __future__ import annotations

import json
import re

import pytest
from cli_harness import is_hex

from protocol_codes import SIMULATED


def test_info_has_model_passports_and_count(mikas):
    found = mikas("info", "--json", sim="&model=5.4").object
    assert found["model"] == "Mikas 5.4"
    assert found["version_code"] == "09"
    assert len(found["program_passport"]) == 3
    assert len(found["data_passport"]) == 5
    assert found["parameter_count"] == SIMULATED
    assert found["echo"] is True
    assert found["supported"]["CREADP (61)"] is True
    assert found["supported"]["CGOTO (41)"] is None
    assert "supported" in mikas("info", "--quick", "--json").object


def test_info_has_null_for_what_a_unit_does_not_answer(mikas):
    found = mikas("info", "--json", sim="&missing=passports,count&echo=0").object
    assert found["program_passport"] == [None] * 3
    assert found["data_passport"] == [None] * 5
    assert found["parameter_count"] is None
    assert found["echo"] is False
    assert found["supported"]["CPASP (51)"] is False


STANDING = """
name = "standing"
duration = 600
[text]
en = "Ignition on, engine off"
ru = "Зажигание включено, двигатель стоит"
[start]
ambient = 20
coolant = 20
coolant_at_start = 20
running = false
[timeline]
key = 1
starter = 0
throttle = 0
"""


def test_info_and_doctor_report_which_commands_were_tried(mikas, tmp_path):
    strokes = [f"CREADPS ({code:02X})" for code in (0x7F, 0x80, 0x81, 0x82, 0x83)]
    found = mikas("info", "--json", sim="&missing=81").object
    tried = [found["supported"][name] for name in (*strokes, "CREADL (63)", "CWRITL (64)")]
    assert tried == [True, True, False, True, True, True, True]
    assert found["not_tried"] == {}
    assert "81 stream at a stroke (2)" in mikas("info").lines[-2]

    (tmp_path / "standing.toml").write_text(STANDING, "utf-8")
    found = mikas("info", "--json", sim="&scenario=standing.toml").object
    assert [found["supported"][name] for name in strokes] == [None] * 5
    assert list(found["not_tried"]) == strokes
    assert found["not_tried"][strokes[0]]["ru"] == "двигатель не вращается"
    assert "the engine is not turning: 7F stream" in mikas("info").lines[-1]
    assert "not tried: 7F 80 81 82 83 (the engine is not turning)" in mikas("doctor").out
    assert "не проверены: 7F 80" in mikas("doctor", "--lang", "ru").out


def test_faults_have_code_text_and_confidence(mikas):
    ran = mikas("faults", "--json", sim="&faults=13,200").object
    assert ran["count"] == 2
    known, unknown = ran["faults"]
    assert {"code", "text", "confidence"} <= set(known)
    assert known["code"] == 13
    assert "Air mass" in known["text"]["en"]
    assert "расхода воздуха" in known["text"]["ru"]
    assert known["confidence"] == "reported"
    assert unknown["text"] == {"en": "", "ru": ""}
    assert unknown["confidence"] == "unknown"


def test_an_erase_reports_the_faults_before_and_after(mikas):
    ran = mikas("faults", "erase", "--yes", "--json", sim="&faults=13,53").object
    assert ran == {"schema": 1, "before": [13, 53], "after": []}


def test_faults_have_the_same_numbers_in_the_question_as_in_the_table(mikas):
    ran = mikas("faults", "erase", sim="&faults=13,53")
    assert [line.split("\t")[0] for line in ran.lines] == ["code", "13", "53"]
    assert "before: 13, 53\n" in ran.err


def test_an_erase_with_the_engine_running_is_asked_about(mikas):
    asked = mikas("faults", "erase", sim="&faults=13&scenario=warm-idle").err
    assert "The engine is running (8" in asked
    assert (
        "сбросить 1 ошибку"
        in mikas("--lang", "ru", "faults", "erase", sim="&faults=13").err.lower()
    )
    assert "Заглушите его" in mikas("--lang", "ru", "faults", "erase", sim="&faults=13").err


def test_memory_is_read_and_written_with_addresses_and_bytes(mikas):
    ran = mikas("mem", "read", "ram", "40", "3", "--json").object
    assert set(ran) == {"schema", "space", "address", "data"}
    assert (ran["space"], ran["address"], len(ran["data"])) == ("ram", 0x40, 6)
    assert is_hex(ran["data"])
    written = mikas("mem", "write", "ram", "40", "0D40", "--yes", "--json").object
    assert set(written) == {"schema", "space", "address", "before", "after"}
    assert (written["before"], written["after"]) == (ran["data"][:4], "0D40")


def test_goto_reports_its_address_and_no_response(mikas):
    ran = mikas("mem", "goto", "8000", "--yes", "--i-know-what-this-does", "--json")
    assert ran.object == {"schema": 1, "address": 0x8000, "response": None}


@pytest.mark.parametrize(
    ("body", "sim", "response"),
    [
        ("02", "&faults=13", "010DE0"),
        ("01", "", "0A"),
        ("fe", "", None),
        ("fe", "&unknown=01", "01"),
    ],
)
def test_raw_reports_request_and_response(mikas, body, sim, response):
    ran = mikas("raw", body, "--yes", "--json", sim=sim).object
    assert ran == {"schema": 1, "request": body.upper(), "response": response}


def test_watch_gives_a_line_a_sample(mikas):
    samples = mikas("watch", "TWAT", "RXX", "--count", "3", "--json").objects
    assert len(samples) == 3
    for sample in samples:
        assert set(sample) == {"schema", "time", "values", "gap"}
        assert sample["schema"] == 1
        assert set(sample["values"]) == {"TWAT", "RXX"}
        assert sample["gap"] is False
        assert type(sample["values"]["RXX"]) is bool
    assert [s["time"] for s in samples] == sorted(s["time"] for s in samples)


def test_doctor_reports_each_step(mikas):
    steps = mikas("doctor", "--json").object["steps"]
    assert [step["name"] for step in steps] == [
        "port", "echo", "baud", "latency", "line", "ecu", "commands",
    ]  # fmt: skip
    for step in steps:
        assert set(step) == {"name", "ok", "detail"}
        assert step["ok"] is True


def test_ports_is_a_list(mikas):
    assert isinstance(mikas("ports", "--json").object["ports"], list)


def test_an_adapter_is_listed_with_chip_and_quirks(mikas, monkeypatch):
    from mikas.cli.commands import ports as module
    from mikas.link import ports as link_ports

    port = link_ports.Port(
        url="COM3",
        description="USB Serial",
        chip="FT232R",
        likely=True,
        quirks=(),
        serial_number="A50285BI",
    )
    monkeypatch.setattr(module, "find_ports", lambda: [port])
    (found,) = mikas("ports", "--json").object["ports"]
    assert {"url", "description", "chip"} <= set(found)
    assert (found["url"], found["chip"], found["likely"]) == ("COM3", "FT232R", True)
    assert found["serial_number"] == "A50285BI"
    assert "A50285BI" in mikas("ports").out


@pytest.mark.parametrize("command", ["demo", "dash"])
def test_the_dashboard_prints_its_address_first(mikas, monkeypatch, command):
    monkeypatch.setattr("mikas.dashboard.server.serve", lambda app, own, *, ready, tls: ready())
    reported = mikas(command, "--no-browser", "--json").object
    assert set(reported) == {"schema", "url", "lan_url", "lan_urls", "fingerprint"}
    assert re.fullmatch(r"http://127\.0\.0\.1:\d+/", reported["url"])
    assert reported["lan_url"] is None


def test_derived_channels_are_listed(mikas):
    derived = {it["name"]: it for it in mikas("params", "--json").object["derived"]}
    assert derived["FUEL_USED"]["accumulates"] is True
    assert set(derived["DUTY"]["inputs"]) == {"INJ", "FREQ"}
    assert set(derived["DUTY"]) == {
        "name", "unit", "formula", "constants", "inputs", "accumulates", "text", "source",
        "confidence",
    }  # fmt: skip
    rows = mikas("params").lines
    (row,) = (line.split("\t") for line in rows if line.startswith("FUEL_USED"))
    assert row[3] == "∫ FUEL_FLOW / 3600"


def test_the_manifest_is_what_dump_prints(mikas, tmp_path):
    ran = mikas("mem", "dump", "ram", "-o", "ram.bin", "--json")
    manifest = ran.object
    assert (manifest["space"], manifest["first"], manifest["last"]) == ("ram", 0, 255)
    assert manifest["complete"] is True
    assert len(manifest["sha256"]) == 64
    same = mikas("mem", "verify", "ram", "ram.bin", "--json").object
    assert same == {"schema": 1, "differences": []}


def test_what_is_no_ascii_survives_a_stream_that_is(mikas, monkeypatch):
    import io
    import sys

    stream = io.TextIOWrapper(io.BytesIO(), encoding="cp1251", errors="replace")
    monkeypatch.setattr(sys, "stdout", stream)
    from mikas.cli.render.output import Output

    Output(json=True).data({"unit": "°C", "text": "обороты λ"})
    stream.flush()
    written = stream.buffer.getvalue().decode("ascii")
    import json

    assert json.loads(written) == {"schema": 1, "unit": "°C", "text": "обороты λ"}


def test_a_long_list_is_written_as_it_comes(capsys) -> None:
    from mikas.cli.render.output import Output

    written = []

    def items():
        for number in range(3):
            yield [number, "x" * 100_000]
            written.append(len(capsys.readouterr().out))

    Output(json=True).long_data({"columns": ["a", "b"]}, "rows", items())
    assert all(count > 90_000 for count in written)
    assert capsys.readouterr().out.endswith("]}\n")
    for count in range(3):
        Output(json=True).long_data({"columns": ["a"]}, "rows", ([it] for it in range(count)))
        whole = {"schema": 1, "columns": ["a"], "rows": [[it] for it in range(count)]}
        assert json.loads(capsys.readouterr().out) == whole
