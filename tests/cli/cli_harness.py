"""The command line run in this process, far from the user's files; and how its words are judged."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from mikas.cli.main import run

SIM = "sim:?clock=simulated"


@dataclass
class Ran:
    """What one command line did."""

    status: int
    out: str
    err: str

    @property
    def lines(self) -> list[str]:
        return self.out.splitlines()

    @property
    def objects(self) -> list[dict]:
        return [json.loads(line) for line in self.lines]

    @property
    def object(self) -> dict:
        (only,) = self.objects
        return only


class Mikas:
    """Calls the command line; `port` is what MIKAS_PORT holds."""

    def __init__(self, capsys, monkeypatch, home: Path) -> None:
        self._capsys = capsys
        self._monkeypatch = monkeypatch
        self.home = home

    def __call__(self, *argv: str, sim: str | None = None) -> Ran:
        """Runs `mikas *argv`; `sim`: settings of the virtual ECU from here on, as `&damaged=1`."""
        if sim is not None:
            self._monkeypatch.setenv("MIKAS_PORT", SIM + sim)
        self._capsys.readouterr()
        status = run(list(argv))
        captured = self._capsys.readouterr()
        return Ran(status, captured.out, captured.err)

    def speaks(self, language: str) -> None:
        """From here on the surroundings ask for `language`."""
        self._monkeypatch.setenv("MIKAS_LANG", language)

    def answers(self, *lines: str) -> None:
        """From here on somebody sits at the terminal and types `lines`."""

        class Terminal:
            def __init__(self) -> None:
                self.left = list(lines)

            def isatty(self) -> bool:
                return True

            def readline(self) -> str:
                return self.left.pop(0) if self.left else ""

        self._monkeypatch.setattr("sys.stdin", Terminal())

    @property
    def journal(self) -> list[dict]:
        """The changes noted so far."""
        (file,) = self.home.glob("state/mikas/journal.jsonl")
        return [json.loads(line) for line in file.read_text("utf-8").splitlines()]


class NoTerminal:
    """What stdin is in a script."""

    def isatty(self) -> bool:
        return False

    def readline(self) -> str:
        raise AssertionError("a question was asked without a terminal")


def is_one_short_paragraph(text: str) -> None:
    assert len(text.strip().splitlines()) == 1, text
    assert len(text) < 900
    assert "Traceback" not in text
    assert not re.search(r"\b(None|\w+Error|\w+Exception|Path\(|b'|<class)", text), text
    assert text.strip()[-1] in ".?" or "--help" in text


NAMES = re.compile(
    r"`[^`]*`|«[^»]*»|(?<![\w-])--?[\w-]+|\b[A-Z][A-Z0-9]{1,8}\b|0x[0-9A-Fa-f]+|\S*[/\\:.]\S+|\b\w+=\w*|"
    r"MIKAS_MQTT_\w+|MQTT|Home Assistant|homeassistant|Node-RED|"
    r"\b(aem|14point7|innovate|nmea|gpsd)\b|"  # instruments beside the unit
    r"K-Line|VAG-COM|PulseView|Wireshark|tshark|Lua|ModemManager|brltty|"
    r"Wi-Fi|Telnet|ESPHome|esp-link|ser2net|"
    r"udev|Linux|Ctrl-C|mikas( [a-z]+){0,3}|pcapng|usermod.*USER"
)
LISTS = re.compile(r"([Ее]сть:?|можно:|Может быть,|имена:|виды:|сценарии:|только) [\w, +×°…-]+")
WORDS = {
    "ram", "xram", "code", "sfr", "en", "ru", "auto", "on", "off", "single", "batch", "list",
    "stream", "corrected", "literal", "alternative", "family", "erase", "log", "capture",
    "sha256", "city",
    "highway", "baud", "byte", "clock", "cold-start", "warm-idle", "full-load", "key-off", "host",
    "real", "simulated", "nan", "inf", "empty", "scenario", "model", "faults", "seed", "sim",
    "Enter", "min", "null", "Tab", "bash", "zsh", "fish", "PowerShell",
    "csv", "msl", "mlg", "parquet", "gpx", "geojson",
    "DuckDB", "Dask", "Parquet", "pandas", "polars", "Spark", "SQL", "CSV", "SELECT", "DESCRIBE",
    "SUMMARIZE", "EXPLAIN", "drives", "samples", "statistics", "gaps", "alarms", "car", "day",
    "processes",
}  # fmt: skip


def is_russian(text: str, *, wordy: bool = True, names: Iterable[str] = ()) -> None:
    """No English words beside names, options and what stands in quotes."""
    plain = NAMES.sub(" ", LISTS.sub("", text))
    left = set(re.findall(r"[A-Za-z][A-Za-z-]{2,}", plain)) - WORDS - set(names)
    assert not left, (left, text)
    assert re.search("[а-я]", text) or not wordy


def is_hex(text: object) -> bool:
    """Whether `text` is bytes in hex, as the JSON writes them."""
    return isinstance(text, str) and re.fullmatch("([0-9A-F]{2})*", text) is not None
