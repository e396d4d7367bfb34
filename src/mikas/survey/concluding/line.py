"""Conclusions on the line: echo, times, checksums, unknown commands (D1, D3, D10, D14)."""

from __future__ import annotations

from statistics import median

from mikas.survey.concluding.conclusion import (
    Conclusion,
    found,
    is_open,
    milliseconds,
    unmeasured,
)
from mikas.survey.steps.step import CarState, Measured

_STRAYS = 10  # one in so many is left out of the spread
_LATE = 0.002  # s; a link that hands bytes over later hides a shorter pause
_FEW = 2e-5  # s between bytes that no unit means: the rounding of times
_CLOSE, _SHARE = 1e-4, 0.1  # s, or of a pause between bytes: how close it must be known


def version(measured: Measured) -> Conclusion:
    """Conclude on the version code (01)."""
    code = measured["version_code"]
    return found(code, f"01 is answered {code}", f"на 01 ответ {code}")


def echo(measured: Measured) -> Conclusion:
    """Conclude on D1."""
    if measured["echo"]:
        return found(True, "the adapter returns what it sends", "адаптер возвращает посланное")
    return found(False, "the adapter returns nothing of what it sends", "адаптер эха не возвращает")


def turn_round(measured: Measured) -> Conclusion:
    """Conclude on the turn-round, the engine standing (D14)."""
    return _turn_round(measured, "turn_round", CarState.STANDING)


def turn_round_running(measured: Measured) -> Conclusion:
    """Conclude on the turn-round, the engine idling (D14)."""
    return _turn_round(measured, "turn_round_running", CarState.IDLE)


def _turn_round(measured: Measured, name: str, state: CarState) -> Conclusion:
    if not measured.get(name):
        return unmeasured(measured, state)
    usual, spread = middle_of(measured[name])
    en, ru = milliseconds(usual)
    en_spread, ru_spread = milliseconds(max(spread, measured["granularity"]))
    value = {"median": usual, "spread": spread, "granularity": measured["granularity"]}
    texts = f"{en} ± {en_spread}", f"{ru} ± {ru_spread}"
    if spread + usual > 2 * measured["granularity"] or measured["granularity"] <= _LATE:
        return found(value, *texts)
    en, ru = milliseconds(measured["granularity"])
    return is_open(
        f"{texts[0]}, no closer: this adapter hands bytes over only every {en}; a cable with a "
        "settable latency timer (FT232R, 1 ms) shows it",
        f"{texts[1]}: адаптер отдаёт байты раз в {ru}; точнее покажет кабель, у которого "
        "задаётся таймер задержки (FT232R, 1 мс)",
        value,
    )


def middle_of(delays: list[float]) -> tuple[float, float]:
    """Return the median, and how far the others lie from it, strays left out."""
    usual = median(delays)
    distances = sorted(abs(delay - usual) for delay in delays)
    kept = distances[: max(1, len(distances) - len(distances) // _STRAYS)]
    return round(usual, 6), round(kept[-1], 6)


def inter_byte(measured: Measured) -> Conclusion:
    """Conclude on pauses between the bytes of a response (D14)."""
    if (figures := measured.get("inter_byte")) is None:
        return unmeasured(measured, CarState.STANDING)
    usual = median(figures["pauses"])
    doubt = measured["granularity"] / max(1, figures["bytes"] - 1)
    en, ru = milliseconds(max(usual, doubt, _FEW))
    if doubt > max(_CLOSE, usual * _SHARE):
        return is_open(
            f"{en} at most, no closer by this adapter, which hands bytes over together",
            f"не больше {ru}; точнее с этим адаптером не узнать: он отдаёт байты пачками",
        )
    if usual <= max(_FEW, doubt):
        return found(0.0, f"none longer than {en}", f"нет длиннее {ru}")
    return found(round(usual, 6), f"{en} between two bytes", f"{ru} между байтами")


def least_pause(measured: Measured) -> Conclusion:
    """Conclude on the least time between a response and the next request."""
    if (figures := measured.get("least_pause")) is None:
        return unmeasured(measured, CarState.STANDING)
    pause, unanswered = figures["pause"], figures["unanswered"]
    if pause is None:
        return is_open(
            "even after a second a request was not answered each time: the line is bad, or the "
            "unit forgets requests",
            "даже через секунду не на каждый запрос есть ответ: плохая связь, или блок теряет "
            "запросы",
        )
    late = measured["granularity"]
    if not unanswered and late > _LATE:
        en, ru = milliseconds(late)
        return is_open(
            f"less than {en}, which this adapter itself leaves between a response and a request",
            f"меньше {ru}: столько между ответом и запросом оставляет сам адаптер",
            0.0,
        )
    if not unanswered:
        return found(
            0.0, "none: requests may follow at once", "не нужна: запросы можно слать подряд"
        )
    en, ru = milliseconds(pause)
    low_en, low_ru = milliseconds(max(unanswered))
    if late > _LATE:  # so much earlier than here the unit's response may have ended
        at_most = round(pause + late, 6)
        en, ru = milliseconds(at_most)
        return found(
            at_most,
            f"{low_en} to {en}, no closer by this adapter, which hands bytes over late",
            f"от {low_ru} до {ru}; точнее с этим адаптером не узнать: он отдаёт байты с опозданием",
        )
    return found(
        pause,
        f"{en}: after {low_en} a request is not answered",
        f"{ru}: через {low_ru} после ответа запрос остаётся без ответа",
    )


def unknown(measured: Measured) -> Conclusion:
    """Conclude on D10."""
    if (answers := measured.get("unknown")) is None:
        return unmeasured(measured, CarState.STANDING)
    forms = set(answers.values())
    if len(forms) > 1:
        listed = ", ".join(f"{code}: {form or '–'}" for code, form in answers.items())
        return is_open(
            f"two unknown codes are answered differently ({listed})",
            f"на два неизвестных кода ответы разные ({listed})",
            answers,
        )
    (form,) = forms
    if form is None:
        return found("silent", "the unit stays silent", "блок молчит")
    return found(form, f"the unit answers {form}", f"блок отвечает {form}")


def checksum_accepted(measured: Measured) -> Conclusion:
    """Conclude on which form of a checksum 0D or 40 the unit takes (D3)."""
    answers = measured.get("checksum_accepted")
    if answers is None:
        return unmeasured(measured, CarState.STANDING)
    if not answers:
        return is_open(
            "no list of known codes has such a checksum; a byte of RAM would have (--memory)",
            "ни у одного списка известных кодов нет такой суммы; подошёл бы байт RAM (--memory)",
        )
    kinds = {
        value: tuple(form for form, is_ok in each.items() if is_ok)
        for value, each in answers.items()
    }
    if len(set(kinds.values())) > 1 or () in kinds.values():
        listed = "; ".join(f"{value}: {', '.join(kind) or '–'}" for value, kind in kinds.items())
        return is_open(
            f"0D and 40 are taken differently ({listed})",
            f"0D и 40 принимаются по-разному ({listed})",
            answers,
        )
    (kind,) = set(kinds.values())
    if len(kind) == 2:
        return found("both", "both forms are understood", "понимает обе формы")
    texts = {
        "stuffed": ("only stuffed is understood", "понимает только с заменой байта"),
        "raw": ("only raw is understood", "понимает только без замены байта"),
    }
    return found(kind[0], *texts[kind[0]])


def checksum_sent(measured: Measured) -> Conclusion:
    """Conclude on the form that the unit sends (D3)."""
    if (forms := measured.get("checksum_sent")) is None:
        return unmeasured(measured, CarState.STANDING)
    kinds = set(forms.values())
    if not kinds:
        return is_open(
            "no data that stand still gave such a checksum",
            "не нашлось неподвижных данных с такой контрольной суммой",
        )
    if len(kinds) > 1:
        return is_open(f"not alike: {forms}", f"не одинаково: {forms}", forms)
    (kind,) = kinds
    texts = {
        "stuffed": ("the unit stuffs its checksum", "блок шлёт её с заменой байта"),
        "raw": ("the unit sends its checksum raw", "блок шлёт её без замены байта"),
    }
    return found(kind, *texts[kind])
