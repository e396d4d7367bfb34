"""Instruments beside the unit on the command line."""

from __future__ import annotations

from pathlib import Path

import pytest
from cli_harness import Mikas

from instrument_recording import record
from mikas.instruments import definition_of_text
from mikas.link.ports import Port

OWN = (
    'text = "Manometer"\ndecoder = "line"\npatterns = ["{PRESSURE} kPa"]\n'
    '[instrument.PRESSURE]\ntext = "Pressure"\nunit = "kPa"\n'
)


def test_export_decodes_an_instrument_by_a_corrected_definition(
    mikas: Mikas, tmp_path: Path
) -> None:
    said = [(0, [(0, b"\n", 0.0, "")])]
    said += [(at, [(0, b"101.5 mbar\n", 0.0, "")]) for at in range(1, 40)]
    record(tmp_path / "a.pcapng", said, ((definition_of_text("own", OWN), ""),))
    assert mikas("export", "a.pcapng", "-o", "a.csv", "PRESSURE").status == 0
    assert (tmp_path / "a.csv").read_text("utf-8").splitlines()[-1].endswith(",")
    (tmp_path / "own.toml").write_text(OWN.replace('kPa"]', 'mbar"]'), encoding="utf-8")
    done = mikas("export", "a.pcapng", "-o", "b.csv", "PRESSURE", "--instrument", "own.toml")
    assert done.status == 0
    assert (tmp_path / "b.csv").read_text("utf-8").splitlines()[-1].endswith(",101.5")


def test_export_names_an_instrument_that_it_can_not_decode(mikas: Mikas, tmp_path: Path) -> None:
    broken = definition_of_text("own", OWN)
    object.__setattr__(broken, "toml", 'text = "x"\ndecoder = "gone"\n')
    record(tmp_path / "a.pcapng", [(1, [(0, b"1\n", 0.0, "")])], ((broken, ""),))
    done = mikas("export", "a.pcapng", "-o", "a.csv")
    assert done.status == 0
    assert "An instrument is not exported" in done.err
    assert "gone" in done.err
    mikas.speaks("ru")
    assert "Прибор не экспортирован" in mikas("export", "a.pcapng", "-o", "b.csv").err


def test_an_adapter_at_which_an_instrument_is_is_not_taken_for_the_units(
    mikas: Mikas, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    names = [str(tmp_path / name) for name in ("meter", "unit")]
    ports = [Port(name, "FT232R", chip="FT232R", likely=True) for name in names]
    monkeypatch.setattr("mikas.link.find_ports", lambda: ports)
    monkeypatch.delenv("MIKAS_PORT")
    for command in (["watch"], ["log", "-o", "a.pcapng"]):
        done = mikas(*command, "FREQ", "--count", "1", "--instrument", f"aem={names[0]}")
        assert done.status == 3
        assert f"There is no port {names[1]}" in done.err


def test_log_records_instruments_and_watch_shows_them(mikas: Mikas, tmp_path: Path) -> None:
    beside = ("--instrument", "aem=sim:", "--instrument", "roof:nmea=sim:")
    done = mikas(
        "log", "-o", "a.pcapng", "FREQ", "--rate", "5", "--duration", "5", "--json", *beside,
        sim="&scenario=city",
    )  # fmt: skip
    assert done.status == 0
    assert "The instrument aem is connected at sim:" in done.err
    last = done.objects[-1]["values"]
    assert list(last) == [
        "FREQ", "LAMBDA", "AFR", "GPS_SPEED_ROOF", "GPS_LAT_ROOF", "GPS_LON_ROOF", "GPS_ALT_ROOF",
        "GPS_COURSE_ROOF",
    ]  # fmt: skip
    assert 0.7 < last["LAMBDA"] < 1.4
    assert last["GPS_LAT_ROOF"] > 56
    done = mikas("export", "a.pcapng", "-o", "a.csv")
    assert done.status == 0
    header = (tmp_path / "a.csv").read_text("utf-8").splitlines()[0]
    assert "GPS_LAT_ROOF Latitude by GPS roof (°)" in header
    done = mikas("watch", "FREQ", "--count", "40", "--rate", "5", *beside)
    assert done.lines[0].split("\t")[1:4] == ["FREQ", "LAMBDA", "AFR"]
    assert done.lines[-1].count("–") == 0
    done = mikas("watch", "FREQ", "--count", "2", "--instrument", "aem=/no/such/port")
    assert done.status == 0  # the unit is sampled all the same


def test_decode_shows_an_instruments_messages_between_the_units_frames(
    mikas: Mikas, tmp_path: Path
) -> None:
    beside = ("--instrument", "left:aem=sim:", "--instrument", "nmea=sim:")
    assert mikas("log", "-o", "a.pcapng", "FREQ", "--duration", "3", *beside).status == 0
    items = mikas("decode", "a.pcapng", "--json").objects
    readings = [it for it in items if it["type"] == "reading"]
    assert {it["instrument"] for it in readings} == {"left:aem", "nmea"}
    meter = [it for it in readings if it["instrument"] == "left:aem"]
    assert len(meter) > 10
    for it in meter:
        assert float(it["text"]) in (it["values"]["AFR_LEFT"], it["values"]["LAMBDA_LEFT"])
        assert bytes.fromhex(it["data"]).decode() == it["text"]
    states = [it["state"] for it in items if it["type"] == "instrument"]
    assert states == ["connected", "connected"]
    frames = [it for it in items if it["type"] == "frame"]
    times = [it["time"] for it in meter]
    assert frames[0]["time"] < times[0] < times[-1] < frames[-1]["time"] + 1
    text = mikas("decode", "a.pcapng", "--lang", "ru").lines
    assert len(text) == len(items)
    (first, *_) = [line for line in text if "LAMBDA_LEFT=" in line]
    assert " = left:aem  «" in first
    assert " = nmea  подключён" in "\n".join(text)


def test_a_wrong_instrument_is_refused_before_anything_is_recorded(
    mikas: Mikas, tmp_path: Path
) -> None:
    for wrong, problem in (("aem", "NAME=URL"), ("ame=COM3", "Did you mean aem")):
        done = mikas("log", "-o", "a.pcapng", "FREQ", "--instrument", wrong)
        assert (done.status, (tmp_path / "a.pcapng").exists()) == (2, False)
        assert problem in done.err


def test_the_tab_key_offers_instruments_and_their_ports(mikas: Mikas) -> None:
    import click
    from click.shell_completion import CompletionItem

    from mikas.cli.completion.values import instruments
    from mikas.cli.options.sampling import INSTRUMENTS

    assert callable(INSTRUMENTS)
    context = click.Context(click.Command("watch"))

    def offered(text: str) -> list[CompletionItem]:
        return instruments(context, click.Argument(["x"]), text)

    assert {it.value for it in offered("a")} >= {"aem="}
    assert "gpsd=gpsd:localhost:2947" in {it.value for it in offered("gpsd=")}
    assert "aem=sim:" in {it.value for it in offered("aem=s")}
