"""Conclusions: an answer to each question, drawn from measured figures alone.

No unit is asked here, so a survey of years ago can be concluded again by better rules.
"""

from __future__ import annotations

from typing import NamedTuple

from mikas.i18n import Text
from mikas.survey.answers import SurveyAnswer
from mikas.survey.concluding import codes, commands, errata, line, streams
from mikas.survey.concluding.conclusion import Conclude
from mikas.survey.steps.step import Measured


class SurveyQuestion(NamedTuple):
    """One question, the clauses that its answer belongs to, and the function that answers it."""

    clauses: tuple[str, ...]
    title: Text
    conclude: Conclude


QUESTIONS: dict[str, SurveyQuestion] = {
    "version": SurveyQuestion(("§3",), Text("version code", "код версии"), line.version),
    "echo": SurveyQuestion(("D1",), Text("echo of the adapter", "эхо адаптера"), line.echo),
    "turn_round": SurveyQuestion(
        ("D14",), Text("time to a response", "время до ответа"), line.turn_round
    ),
    "turn_round_running": SurveyQuestion(
        ("D14", "D16"),
        Text("time to a response, engine running", "время до ответа на работающем двигателе"),
        line.turn_round_running,
    ),
    "inter_byte": SurveyQuestion(
        ("D14",), Text("pauses inside a response", "паузы внутри ответа"), line.inter_byte
    ),
    "least_pause": SurveyQuestion(
        ("D14",),
        Text("least pause before a request", "наименьшая пауза перед запросом"),
        line.least_pause,
    ),
    "unknown": SurveyQuestion(
        ("D10",), Text("unknown commands", "неизвестные команды"), line.unknown
    ),
    "commands": SurveyQuestion(
        ("§3", "D10"), Text("commands", "команды"), commands.commands
    ),
    "counted_blocks": SurveyQuestion(
        ("D7",), Text("form of 23 and 25", "вид ответа 23 и 25"), commands.counted_blocks
    ),
    "max_block": SurveyQuestion(
        ("§3",), Text("largest block of memory", "наибольший блок памяти"), commands.max_block
    ),
    **{
        f"max_list_{code}": SurveyQuestion(
            ("D11",),
            Text(f"greatest list of {code}", f"наибольший список {code}"),
            commands.max_list(code),
        )
        for code in ("61", "64", "71")
    },
    "long_list": SurveyQuestion(
        ("D11",), Text("too long a list", "слишком длинный список"), commands.long_list
    ),
    "list_bytes": SurveyQuestion(
        ("D11",), Text("limit in codes or bytes", "предел в кодах или байтах"), commands.list_bytes
    ),
    "bad_write": SurveyQuestion(
        ("D17",), Text("a write that can't be done", "невыполнимая запись"), commands.bad_write
    ),
    "writes": SurveyQuestion(
        ("D6", "D8", "D9"), Text("writes and jumps", "записи и переходы"), commands.writes
    ),
    "checksum_accepted": SurveyQuestion(
        ("D3",),
        Text("checksum 0D or 40 to the unit", "контрольная сумма 0D или 40 к блоку"),
        line.checksum_accepted,
    ),
    "checksum_sent": SurveyQuestion(
        ("D3",),
        Text("checksum 0D or 40 of the unit", "контрольная сумма 0D или 40 от блока"),
        line.checksum_sent,
    ),
    "stream_end": SurveyQuestion(
        ("D12",), Text("end of a stream", "конец потока"), streams.stream_end
    ),
    "stream_gap": SurveyQuestion(
        ("D16",), Text("pause between responses of a stream", "пауза между ответами потока"),
        streams.stream_gap,
    ),
    "stream_load": SurveyQuestion(
        ("D16",), Text("that pause and the engine's speed", "эта пауза и обороты"),
        streams.stream_load,
    ),
    "strokes": SurveyQuestion(
        ("D15",), Text("streams by strokes", "потоки по тактам"), streams.strokes
    ),
    "codes": SurveyQuestion(("§4", "D10"), Text("codes 00–FF", "коды 00–FF"), codes.codes),
    "moves": SurveyQuestion(
        ("§4",), Text("what the data follow", "за чем следуют значения"), codes.moves
    ),
    "count": SurveyQuestion(
        ("§3",), Text("number of parameters", "число параметров"), commands.count
    ),
    "passports": SurveyQuestion(("§3",), Text("passports", "паспорта"), commands.passports),
    "faults": SurveyQuestion(("§3",), Text("stored faults", "запомненные ошибки"), commands.faults),
    "freq": SurveyQuestion(("E1",), Text("unit of FREQ", "единица FREQ"), errata.freq),
    "uacc_sign": SurveyQuestion(("E2",), Text("sign of UACC", "знак UACC"), errata.uacc_sign),
    "uacc_scale": SurveyQuestion(
        ("E2",), Text("formula of UACC", "формула UACC"), errata.uacc_scale
    ),
    "fuel_factors": SurveyQuestion(
        ("E3",), Text("RCOK and RCOD at warm idle", "RCOK и RCOD на прогретом холостом ходу"),
        errata.fuel_factors,
    ),
    "tair": SurveyQuestion(("E4",), Text("size of TAIR", "размер TAIR"), errata.tair),
    "valf": SurveyQuestion(
        ("§4",), Text("VALF at warm idle", "VALF на прогретом холостом ходу"), errata.valf
    ),
}  # fmt: skip
"""Each question by its name, in the order of the clauses' subjects."""


def conclude(measured: Measured) -> tuple[SurveyAnswer, ...]:
    """Return the answer to each question, by what was measured.

    Raises `ValueError`, `TypeError` or `LookupError` for figures that no survey measures.
    """
    answers = []
    for name, question in QUESTIONS.items():
        verdict, text, value = question.conclude(measured)
        answers.append(SurveyAnswer(name, question.clauses, verdict, question.title, text, value))
    return tuple(answers)
