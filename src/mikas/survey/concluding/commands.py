"""Conclusions on commands: which there are, lists, blocks, passports, faults (§3, D7, D11, D17)."""

from __future__ import annotations

from mikas.commands import COMMANDS_BY_CODE
from mikas.i18n import counted
from mikas.survey.concluding.conclusion import (
    Conclude,
    Conclusion,
    found,
    is_open,
    no_codes,
    not_asked,
    unmeasured,
)
from mikas.survey.steps.commands import fault_numbers
from mikas.survey.steps.step import CarState, Measured

_BEYOND = {
    "short": ("a longer one is answered cut", "на более длинный ответ укорочен"),
    "01": ("a longer one is answered 01", "на более длинный ответ 01"),
    "silent": ("a longer one gets no answer", "более длинный остаётся без ответа"),
    "other": ("a longer one gets an answer of another form", "на более длинный ответ иной"),
}
_NO_MEMORY = not_asked(
    "memory is read only with consent (--memory)", "память читается только с согласия (--memory)"
)


def support(measured: Measured) -> dict[str, bool]:
    """Return which commands the unit has, of those that were tried, by code."""
    known: dict[str, bool] = dict(measured.get("commands", {}))
    passports = measured.get("passports")
    if passports is not None:
        for code, each in passports.items():
            known[code] = each is not None and not each["refused"]
    for code, each in measured.get("strokes", {}).items():
        known[code] = each["rate"] is not None
    return dict(sorted(known.items()))


def commands(measured: Measured) -> Conclusion:
    """Conclude on which commands of §3 the unit has."""
    if "commands" not in measured:
        return unmeasured(measured, CarState.STANDING)
    known = support(measured)
    has = [code for code, is_known in known.items() if is_known]
    lacks = [code for code, is_known in known.items() if not is_known]
    untried = [f"{code:02X}" for code in sorted(COMMANDS_BY_CODE) if f"{code:02X}" not in known]
    en, ru = f"has {' '.join(has)}", f"есть {' '.join(has)}"
    if lacks:
        en, ru = f"{en}; lacks {' '.join(lacks)}", f"{ru}; нет {' '.join(lacks)}"
    if untried:
        en, ru = f"{en}; not tried {' '.join(untried)}", f"{ru}; не проверены {' '.join(untried)}"
    return found({"supported": has, "missing": lacks, "untried": untried}, en, ru)


def counted_blocks(measured: Measured) -> Conclusion:
    """Conclude on D7."""
    if not measured["memory"]:
        return _NO_MEMORY
    blocks = measured.get("blocks")
    if blocks is None:
        return unmeasured(measured, CarState.STANDING)
    forms = {code: each["counted"] for code, each in blocks.items() if code in ("23", "25")}
    known = {form for form in forms.values() if form is not None}
    if len(known) != 1:
        return is_open(
            f"the unit answers neither 23 nor 25, or not alike ({forms or '–'})",
            f"на 23 и 25 блок не отвечает или отвечает по-разному ({forms or '–'})",
            forms,
        )
    if known == {True}:
        return found(True, "23 and 25 repeat the count", "в ответе 23 и 25 есть число байтов")
    return found(False, "23 and 25 do not repeat the count", "в ответе 23 и 25 числа байтов нет")


def max_block(measured: Measured) -> Conclusion:
    """Conclude on the largest blocks of 21, 23 and 25."""
    if not measured["memory"]:
        return _NO_MEMORY
    blocks = measured.get("blocks")
    if blocks is None:
        return unmeasured(measured, CarState.STANDING)
    limits = {code: each["limit"] for code, each in blocks.items() if each["limit"] is not None}
    if not limits:
        return is_open("the unit gives no block", "блок не отдаёт ни одного блока памяти")
    listed = ", ".join(f"{code}: {limit}" for code, limit in limits.items())
    return found(limits, f"bytes: {listed}", f"байтов: {listed}")


def max_list(command: str) -> Conclude:
    """Return the conclusion on the greatest list of one command (D11)."""

    def conclude(measured: Measured) -> Conclusion:
        figures = measured.get("lists", {}).get(command)
        if figures is None:
            return unmeasured(measured, CarState.STANDING)
        limit, beyond = figures["limit"], figures["beyond"]
        if limit is None:
            if not support(measured).get(command, True):
                return is_open(f"the unit lacks {command}", f"команды {command} у блока нет")
            return no_codes()
        if beyond is None:
            return found(
                limit, f"{limit}, the most that was asked for", f"{limit}: больше не спрашивали"
            )
        en, ru = _BEYOND[beyond]
        return found(limit, f"{limit}; {en}", f"{limit}; {ru}")

    return conclude


def long_list(measured: Measured) -> Conclusion:
    """Conclude on the response to too long a list of 61 or 71 (D11)."""
    lists = measured.get("lists")
    if lists is None:
        return unmeasured(measured, CarState.STANDING)
    forms = {lists[name]["beyond"] for name in ("61", "71") if lists[name]["limit"] is not None}
    forms.discard(None)
    if not forms:
        return is_open(
            "no list was too long for this unit", "ни один список не оказался слишком длинным"
        )
    if len(forms) > 1:
        listed = ", ".join(sorted(forms))
        return is_open(f"not alike: {listed}", f"не одинаково: {listed}", sorted(forms))
    (form,) = forms
    return found(form, *_BEYOND[form])


def list_bytes(measured: Measured) -> Conclusion:
    """Conclude on whether a list is limited in codes or in bytes of its response (D11)."""
    if "lists" not in measured:
        return unmeasured(measured, CarState.STANDING)
    if (is_by_codes := measured.get("list_bytes")) is None:
        return is_open(
            "no limit was met, or the unit has no code of two bytes",
            "предела не встретили, или у блока нет двухбайтового кода",
        )
    if is_by_codes:
        return found("codes", "codes are counted, not bytes", "считаются коды, а не байты")
    return found("bytes", "the bytes of the response are counted", "считаются байты ответа")


def bad_write(measured: Measured) -> Conclusion:
    """Conclude on D17: only by a 64 with too long a list, for no other write is sent."""
    figures = measured.get("lists", {}).get("64", {})
    if figures.get("limit") is not None and figures["beyond"] in ("01", "silent"):
        return found(figures["beyond"], *_BEYOND[figures["beyond"]])
    return not_asked(
        "a survey sends no write that a unit could refuse; no list of 64 was too long",
        "обследование не делает записей, от которых блок мог бы отказаться; слишком длинного "
        "списка 64 не встретилось",
    )


def count(measured: Measured) -> Conclusion:
    """Conclude on the number of parameters (60)."""
    if "count" not in measured:
        return unmeasured(measured, CarState.STANDING)
    body = measured["count"]
    if body is None or len(body) != 2 or body == "01":
        return is_open(
            f"the answer to 60 is {body or 'silence'}",
            f"ответ на 60: {body or 'молчание'}",
        )
    return found(int(body, 16), f"{int(body, 16)} by 60", f"по команде 60 — {int(body, 16)}")


def passports(measured: Measured) -> Conclusion:
    """Conclude on 51–58: with consent their texts, else their lengths."""
    pieces = measured.get("passports")
    if pieces is None:
        return unmeasured(measured, CarState.STANDING)
    lengths = {code: None if each is None else each["bytes"] for code, each in pieces.items()}
    listed = " ".join(f"{code}: {'–' if n is None else n}" for code, n in lengths.items())
    if measured["passports_consent"]:
        return found(lengths, f"texts kept; bytes {listed}", f"тексты сохранены; байтов {listed}")
    return found(
        lengths,
        f"texts not kept, by your choice; bytes {listed}",
        f"тексты не сохранены, как вы выбрали; байтов {listed}",
    )


def faults(measured: Measured) -> Conclusion:
    """Conclude on the stored faults (02) and their separator."""
    if "faults" not in measured:
        return unmeasured(measured, CarState.STANDING)
    body = measured["faults"]
    numbers = fault_numbers(body)
    if numbers is None:
        return is_open(
            f"the answer to 02 is {body or 'silence'}: no list as §3 has it",
            f"ответ на 02: {body or 'молчание'} — это не список по §3",
            body,
        )
    number = counted(len(numbers), ("fault", "faults"), ("ошибка", "ошибки", "ошибок"))
    listed = ", ".join(map(str, numbers))
    return found(list(numbers), f"{number.en}: {listed or '–'}", f"{number.ru}: {listed or '–'}")


def writes(_: Measured) -> Conclusion:
    """Conclude on D6, D8, D9: nothing that writes or jumps is sent."""
    return not_asked(
        "a survey sends nothing that writes, erases or jumps (12 14 16 22 24 26 32 41 62)",
        "обследование не посылает ничего, что пишет, стирает или переходит (12 14 16 22 24 26 32 "
        "41 62)",
    )
