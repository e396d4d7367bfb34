"""The states of the car: the person's instruction, and how the unit shows that it is reached."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import Final

from mikas import errors
from mikas.i18n import Text
from mikas.survey.person import Prompter
from mikas.survey.steps.engine import RUNNING
from mikas.survey.steps.step import CarState
from mikas.survey.unit import COOLANT, SurveyedUnit

_PATIENCE: Final = 300.0  # s for a person to do it
_WARMING: Final = 1800.0  # s for a cold engine in winter
_REMINDED: Final = 30.0  # s; of a long wait,
_REMINDED_OF_LONG: Final = 300.0
_LOOKED: Final = 0.5  # s between two looks at the unit
_LOOKS: Final = 3  # that show another state, until the car has left the one it was in
_WARM: Final = 75 + 40  # raw TWAT (§4)
_IDLE: Final = (RUNNING, 1900.0)  # rpm, of a cold engine too
_RAISED: Final = (2000.0, 3300.0)
_Shown = Callable[[SurveyedUnit], bool | None]


@dataclass(frozen=True, slots=True)
class _Instruction:
    """How to reach one state. `shown`: whether the unit shows it; None: it does not say."""

    text: Text
    shown: _Shown
    patience: float
    not_reached: Text


def bring(unit: SurveyedUnit, state: CarState, person: Prompter) -> Text | None:
    """Have the car brought into `state`; return the reason if it was not, None if it was."""
    instruction = _INSTRUCTIONS[state]
    if state is CarState.STARTING:
        if _looked(unit, _runs):
            return _RUNS_ALREADY
        person.say(instruction.text)
        return None
    shown = _looked(unit, instruction.shown)
    if shown:
        return None
    person.say(instruction.text)
    if shown is None:
        return None if person.ready(instruction.text) else _NOT_SHOWN
    began = said = unit.now()
    while (now := unit.now()) < began + instruction.patience:
        if _looked(unit, instruction.shown):
            return None
        if now - said > (_REMINDED if instruction.patience == _PATIENCE else _REMINDED_OF_LONG):
            person.say(instruction.text)
            said = now
        unit.pause(_LOOKED)
    return instruction.not_reached


def has_left(unit: SurveyedUnit, state: CarState) -> bool:
    """Return whether the car is in another state by now: the engine stalled, the pedal was let go.

    False also where the unit does not show it; a single look may be wrong on a bad line.
    """
    if state is CarState.STARTING:
        return False
    for _ in range(_LOOKS):
        if _looked(unit, _INSTRUCTIONS[state].shown) is not False:
            return False
        unit.pause(_LOOKED)
    return True


def _looked(unit: SurveyedUnit, shown: _Shown) -> bool | None:
    """Look at the unit; while the key is turned it may be off, which is no end of the survey."""
    try:
        return shown(unit)
    except (errors.EchoOnly, errors.NoEcho, errors.SyncLost, errors.LineError):
        return False


def _between(low: float, high: float) -> _Shown:
    def shown(unit: SurveyedUnit) -> bool | None:
        rpm = unit.rpm() if unit.speed_codes else None
        if not unit.speed_codes:
            return None
        return rpm is not None and low <= rpm <= high

    return shown


def _is_warm(unit: SurveyedUnit) -> bool | None:
    if unit.sizes.get(COOLANT) != 1:
        return None
    raw = unit.data([COOLANT]).get(COOLANT)
    return raw is not None and raw[0] >= _WARM and _at_idle(unit) is not False


_at_idle = _between(*_IDLE)
_runs = _between(RUNNING, inf)
_NOT_SHOWN: Final = Text(
    "the unit does not show whether the car is ready for it, and no person has said so",
    "блок не показывает, готова ли машина, и человек этого не подтвердил",
)
_RUNS_ALREADY: Final = Text(
    "the engine ran already when the survey looked on",
    "к этому шагу двигатель уже работал",
)
ENGINE_OFF: Final = Text(
    "Ignition on, engine OFF. Stop the engine and turn the key on again.",
    "Зажигание включено, двигатель ЗАГЛУШЕН. Заглушите двигатель и снова включите зажигание.",
)
"""The instruction that a survey begins with."""
_INSTRUCTIONS: Final = {
    CarState.STANDING: _Instruction(
        ENGINE_OFF,
        _between(0, 0),
        _PATIENCE,
        Text("the engine was not stopped within 5 minutes", "двигатель не заглушили за 5 минут"),
    ),
    CarState.STARTING: _Instruction(
        Text(
            "Neutral, handbrake, fresh air. START the engine now.",
            "Нейтраль, ручной тормоз, свежий воздух. ПУСТИТЕ двигатель сейчас.",
        ),
        _between(0, RUNNING),
        _PATIENCE,
        Text("the engine was not started", "двигатель не пустили"),
    ),
    CarState.IDLE: _Instruction(
        Text(
            "Let the engine idle; do not touch the pedal.",
            "Двигатель на холостом ходу; педаль не трогайте.",
        ),
        _at_idle,
        _PATIENCE,
        Text(
            "the engine did not idle within 5 minutes",
            "двигатель за 5 минут не вышел на холостой ход",
        ),
    ),
    CarState.WARM: _Instruction(
        Text(
            "Let it idle until it is warm (75 °C). The survey goes on by itself.",
            "Дайте прогреться на холостом ходу до 75 °C. Дальше само.",
        ),
        _is_warm,
        _WARMING,
        Text(
            "the engine was not warm (75 °C) after half an hour",
            "двигатель за полчаса не прогрелся до 75 °C",
        ),
    ),
    CarState.RAISED: _Instruction(
        Text(
            "Hold the engine at 2,500 rpm until the next instruction, about 15 seconds.",
            "Держите 2500 об/мин до следующей команды, около 15 секунд.",
        ),
        _between(*_RAISED),
        _PATIENCE,
        Text(
            "the engine was not held at 2,000 to 3,300 rpm within 5 minutes",
            "за 5 минут обороты не подняли до 2000–3300",
        ),
    ),
    CarState.AFTER: _Instruction(
        Text("Release the pedal: idle again.", "Отпустите педаль: снова холостой ход."),
        _at_idle,
        _PATIENCE,
        Text(
            "the engine did not come back to idle within 5 minutes",
            "двигатель за 5 минут не вернулся на холостой ход",
        ),
    ),
}
