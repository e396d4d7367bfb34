"""All steps of a survey in their order."""

from __future__ import annotations

from mikas.i18n import Text
from mikas.survey.person import Prompter
from mikas.survey.steps import checksums, codes, commands, engine, lists, streams, timing
from mikas.survey.steps.step import CarState, Measure, Measured, SurveyStep
from mikas.survey.unit import SurveyedUnit


def _step(
    name: str, state: CarState, en: str, ru: str, measure: Measure, *, keeps: bool = False
) -> SurveyStep:
    return SurveyStep(name, state, Text(en, ru), measure, keeps)


def _sampled(state: CarState) -> Measure:
    def measure(unit: SurveyedUnit, measured: Measured, person: Prompter) -> None:
        codes.sample(unit, measured, person, state.value)

    return measure


def _streamed(state: CarState) -> Measure:
    def measure(unit: SurveyedUnit, measured: Measured, person: Prompter) -> None:
        streams.cyclic(unit, measured, person, state.value)

    return measure


_OFF, _IDLE, _RAISED = CarState.STANDING, CarState.IDLE, CarState.RAISED

STEPS: tuple[SurveyStep, ...] = (
    _step("least_pause", _OFF, "pause before a request", "пауза перед запросом",
          timing.least_pause),
    _step("turn_round", _OFF, "time to a response", "время до ответа", timing.turn_round),
    _step("unknown", _OFF, "unknown commands", "неизвестные команды", commands.unknown),
    _step("codes", _OFF, "codes 00–FF", "коды 00–FF", codes.scan, keeps=True),
    _step("commands", _OFF, "commands", "команды", commands.support),
    _step("lists", _OFF, "greatest lists", "наибольшие списки", lists.lists),
    _step("checksum_accepted", _OFF, "checksums to the unit", "контрольные суммы к блоку",
          checksums.accepted),
    _step("checksum_sent", _OFF, "checksums of the unit", "контрольные суммы от блока",
          checksums.sent),
    _step("inter_byte", _OFF, "pauses inside a response", "паузы внутри ответа",
          timing.inter_byte),
    _step("blocks", _OFF, "blocks of memory", "блоки памяти", commands.blocks),
    _step("stream_end", _OFF, "end of a stream", "конец потока", streams.end_of_stream),
    _step("stream_standing", _OFF, "stream, engine standing", "поток, двигатель стоит",
          _streamed(_OFF)),
    _step("passports", _OFF, "passports", "паспорта", commands.passports),
    _step("faults", _OFF, "faults", "ошибки", commands.faults),
    _step("samples_standing", _OFF, "values, engine standing", "значения, двигатель стоит",
          _sampled(_OFF)),
    _step("voltage", _OFF, "voltage", "напряжение", engine.voltage),
    _step("cranking", CarState.STARTING, "start of the engine", "пуск двигателя",
          engine.cranking),
    _step("samples_idle", _IDLE, "values at idle", "значения на холостом ходу", _sampled(_IDLE)),
    _step("turn_round_running", _IDLE, "time to a response, engine running",
          "время до ответа на работающем двигателе", timing.turn_round_running),
    _step("stream_idle", _IDLE, "stream at idle", "поток на холостом ходу", _streamed(_IDLE)),
    _step("strokes", _IDLE, "streams by strokes", "потоки по тактам", streams.strokes),
    _step("tachometer", _IDLE, "tachometer", "тахометр", engine.tachometer),
    _step("starter", _IDLE, "starter, timed by hand", "стартёр, счёт вручную", engine.starter,
          keeps=True),
    _step("codes_again", _IDLE, "silent codes once more", "молчащие коды ещё раз",
          codes.scan_again, keeps=True),
    _step("factors", CarState.WARM, "fuel corrections, warm", "коррекции топлива, прогретый",
          engine.factors),
    _step("samples_warm", CarState.WARM, "values at warm idle",
          "значения на прогретом холостом ходу", _sampled(CarState.WARM)),
    _step("samples_raised", _RAISED, "values at raised speed", "значения на поднятых оборотах",
          _sampled(_RAISED)),
    _step("stream_raised", _RAISED, "stream at raised speed", "поток на поднятых оборотах",
          _streamed(_RAISED)),
    _step("strokes_raised", _RAISED, "stream by strokes at raised speed",
          "поток по тактам на поднятых оборотах", streams.strokes_raised),
    _step("samples_after", CarState.AFTER, "values at idle again",
          "значения снова на холостом ходу", _sampled(CarState.AFTER)),
)  # fmt: skip
"""In the order of the car's states; within one each step needs what those before have found."""

STANDING_AGAIN = SurveyStep(
    "codes_again",
    _OFF,
    Text("silent codes once more", "молчащие коды ещё раз"),
    codes.scan_again,
    keeps=True,
)
"""In the place of the step at idle, in a survey without the engine."""
