"""Instruments beside the unit on the command line."""

from __future__ import annotations

from pathlib import Path

from cli_harness import Mikas

from instrument_recording import record
from mikas.instruments import definition_of_text

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
