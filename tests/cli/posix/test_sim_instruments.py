"""`mikas sim --instrument`: a λ meter and a GPS on ptys beside the unit's, for another program."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import mikas

pytestmark = [pytest.mark.realtime, pytest.mark.posix]
PROGRAM = [sys.executable, "-c", "from mikas.cli.main import main; main()"]


def test_a_drive_with_both_is_recorded_over_ptys(tmp_path: Path) -> None:
    arguments = ["sim", "--scenario", "city", "--instrument", "aem", "--instrument", "nmea"]
    environment = {**os.environ, "HOME": str(tmp_path), "MIKAS_LANG": "en"}
    with subprocess.Popen(
        [*PROGRAM, *arguments, "--json"], stdout=subprocess.PIPE, text=True, env=environment
    ) as process:
        try:
            assert process.stdout is not None
            unit, meter, receiver = (json.loads(process.stdout.readline()) for _ in range(3))
            assert "instrument" not in unit
            assert [meter["instrument"], receiver["instrument"]] == ["aem", "nmea"]
            log = subprocess.run(
                [
                    *PROGRAM, "log", "-o", "a.pcapng", "FREQ", "VALF", "--port", unit["url"],
                    "--instrument", f"aem={meter['url']}",
                    "--instrument", f"nmea={receiver['url']}", "--duration", "5", "--json",
                ],
                cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=60,
                check=True,
            )  # fmt: skip
        finally:
            process.send_signal(signal.SIGINT)
    last = json.loads(log.stdout.splitlines()[-1])["values"]
    assert last["LAMBDA"] == pytest.approx(last["VALF"], abs=0.25)
    frame = mikas.open(tmp_path / "a.pcapng").to_pandas()
    assert frame["LAMBDA"].notna().sum() > 100
    assert frame["GPS_LAT"].dropna().iloc[-1] == pytest.approx(56.3, abs=0.05)


def test_a_recording_has_no_virtual_instruments(tmp_path: Path) -> None:
    path = tmp_path / "a.pcapng"
    with mikas.session("sim:?clock=simulated", ["FREQ"], count=5, record=path) as session:
        session.run()
    done = subprocess.run(
        [*PROGRAM, "sim", "--replay", str(path), "--instrument", "aem"],
        env={**os.environ, "MIKAS_LANG": "en"}, capture_output=True, text=True, timeout=60,
        check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert "can't be used with --replay" in done.stderr
