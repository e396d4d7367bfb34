"""Figures that need the engine or the person's instruments: E1–E4, VALF."""

from __future__ import annotations

from typing import Final

from mikas import errors
from mikas.i18n import Text
from mikas.survey.person import Prompter
from mikas.survey.steps.step import Measured
from mikas.survey.unit import SPEED, VOLTAGE, SurveyedUnit, speed_of

RUNNING = 500.0  # rpm, above which an engine runs by itself
_LOOKED = 0.1  # s between two looks at an engine that stands
_STARTED_FOR = 3.0  # s that it runs by itself
_CRANKING = 300.0  # s of looking on, at most
FACTORS = (0x42, 0x41, 0x39)  # RCOK, RCOD, VALF
_SAMPLES = 10
_APART = 0.5  # s
FIGURES: Final = {
    "voltmeter": (Text("V", "В"), 6.0, 18.0),
    "tachometer": (Text("rpm", "об/мин"), 200.0, 3000.0),
    "starter": (Text("puffs a second", "тактов в секунду"), 1.0, 20.0),
}
"""The figures that a person may have, by name: the unit, the smallest and the greatest."""


def voltage(unit: SurveyedUnit, measured: Measured, person: Prompter) -> None:
    """Ask for a voltmeter's figure at the battery, and read UACC beside it (E2)."""
    if unit.sizes.get(VOLTAGE) != 1:
        return
    meter = person.number(
        "voltmeter",
        Text(
            "Voltmeter at the battery's terminals, ignition on, engine off: how many volts?",
            "Вольтметр на клеммах аккумулятора, зажигание включено, двигатель заглушен: сколько "
            "вольт?",
        ),
        *FIGURES["voltmeter"],
    )
    measured["voltage"] = {"meter": meter, "raw": _several(unit, VOLTAGE)}


def tachometer(unit: SurveyedUnit, measured: Measured, person: Prompter) -> None:
    """Ask for the speed that the dashboard shows, and read FREQ beside it (E1)."""
    if unit.sizes.get(SPEED) != 1:
        return
    shown = person.number(
        "tachometer",
        Text(
            "The tachometer on the dashboard: how many rpm now?",
            "Тахометр на щитке: сколько оборотов сейчас?",
        ),
        *FIGURES["tachometer"],
    )
    measured["tachometer"] = {"shown": shown, "raw": _several(unit, SPEED)}


def starter(_: SurveyedUnit, measured: Measured, person: Prompter) -> None:
    """Ask how fast the starter turned the engine, timed by hand (E1): FREQ was read beside it."""
    if not measured.get("cranking"):
        return
    puffs = person.number(
        "starter",
        Text(
            "The starter, timed by hand (a phone's film, played slowly): how many puffs of the "
            "engine a second, two in a turn?",
            "Стартёр, счёт вручную (снять телефоном и посмотреть медленно): сколько тактов сжатия "
            "в секунду, два за оборот?",
        ),
        *FIGURES["starter"],
    )
    measured["starter"] = {"puffs": puffs}


def _several(unit: SurveyedUnit, code: int) -> list[str]:
    data = [unit.data([code]).get(code) for _ in range(_SAMPLES)]
    return [raw.hex().upper() for raw in data if raw is not None]


def cranking(unit: SurveyedUnit, measured: Measured, _: Prompter) -> None:
    """Read speed and voltage while the starter turns, until the engine runs by itself (E1)."""
    if not unit.speed_codes:
        return  # nothing shows when the engine runs
    codes = [code for code in (*unit.speed_codes, VOLTAGE) if code in unit.sizes]
    rows: list[list[object]] = []
    began = unit.now()
    runs_since: float | None = None
    while (now := unit.now()) < began + _CRANKING:
        data = _data_if_on(unit, codes)
        speed = speed_of(data) or 0.0
        turns = any(data.get(code, b"\0") != b"\0" for code in unit.speed_codes)
        if turns:
            listed = {f"{code:02X}": raw.hex().upper() for code, raw in data.items()}
            rows.append([round(now - began, 3), listed])
        if speed <= RUNNING:
            runs_since = None
        elif runs_since is None:
            runs_since = now
        if runs_since is not None and now - runs_since > _STARTED_FOR:
            break
        if not turns:
            unit.pause(_LOOKED)
    measured["cranking"] = rows


def _data_if_on(unit: SurveyedUnit, codes: list[int]) -> dict[int, bytes]:
    """Return the data; none while the starter takes the unit's supply away."""
    try:
        return unit.data(codes)
    except (errors.NoEcho, errors.EchoOnly, errors.LineError):
        return {}


def factors(unit: SurveyedUnit, measured: Measured, person: Prompter) -> None:
    """Read RCOK, RCOD and VALF at warm idle, as raw bytes (E3)."""
    codes = [code for code in FACTORS if code in unit.sizes]
    samples: dict[str, list[str]] = {}
    for done in range(_SAMPLES):
        for code, raw in unit.data(codes).items():
            samples.setdefault(f"{code:02X}", []).append(raw.hex().upper())
        unit.pause(_APART)
        person.progress(done + 1, _SAMPLES)
    measured["factors"] = samples
