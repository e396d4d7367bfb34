"""`README.txt` of a survey's ZIP: what it holds, what it does not, and the answers, en and ru."""

from __future__ import annotations

from mikas.i18n import Language
from mikas.survey.answers import SurveyAnswer, SurveyVerdict
from mikas.survey.archive import SurveyFile

_HEAD: dict[Language, str] = {
    "en": (
        "A survey of a Mikas control unit, made by mikas {version} (https://github.com/"
        "mikas-diagnostics/mikas).\n\n"
        "survey.json     the answers, each with its clauses, and the figures behind them\n"
        "unit.json       the unit's profile: mikas sim --unit THIS.zip answers as the unit does\n"
        "capture.pcapng  the bytes on the wire; times count from the begin, there is no date\n\n"
        "Nothing here names a person, a car, a place or a date. Passports of the unit: {passports}."
        " Memory: {memory}.\nNothing was written to the unit but the list of 64, which a power "
        "cycle ends.\n"
    ),
    "ru": (
        "Обследование блока Микас программой mikas {version} (https://github.com/"
        "mikas-diagnostics/mikas).\n\n"
        "survey.json     ответы, каждый с пунктами протокола, и измеренные числа\n"
        "unit.json       профиль блока: mikas sim --unit ЭТОТ.zip отвечает, как этот блок\n"
        "capture.pcapng  байты на линии; время от начала, без даты\n\n"
        "Здесь нет ни имён, ни номера машины, ни места, ни даты. Паспорта блока: {passports}. "
        "Память: {memory}.\nВ блок ничего не записано, кроме списка 64, который пропадает с "
        "питанием.\n"
    ),
}
_KEPT: dict[Language, tuple[str, str]] = {
    "en": ("texts kept, with consent", "not kept"),
    "ru": ("тексты сохранены с согласия", "не сохранены"),
}
_READ: dict[Language, tuple[str, str, str]] = {
    "en": ("read, with consent", "read, with consent; its blocks are not kept", "not read"),
    "ru": ("читалась с согласия", "читалась с согласия, её блоки не сохранены", "не читалась"),
}
_VERDICTS: dict[Language, dict[SurveyVerdict, str]] = {
    "en": {
        SurveyVerdict.FOUND: "found",
        SurveyVerdict.OPEN: "open",
        SurveyVerdict.NOT_ASKED: "not asked",
    },
    "ru": {
        SurveyVerdict.FOUND: "найдено",
        SurveyVerdict.OPEN: "открыто",
        SurveyVerdict.NOT_ASKED: "не спрошено",
    },
}


def readme(content: SurveyFile) -> str:
    """Return the text of both languages."""
    return "\n\n".join(_part(content, language) for language in ("en", "ru")) + "\n"


def verdict_word(answer: SurveyAnswer, language: Language) -> str:
    """Return the verdict in words."""
    return _VERDICTS[language][answer.verdict]


def _kept_of_memory(content: SurveyFile) -> int:
    """Return the place in `_READ`: a block may hold passports, so it is kept where these are."""
    if not content.measured["memory"]:
        return 2
    return 0 if content.measured["passports_consent"] else 1


def _part(content: SurveyFile, language: Language) -> str:
    head = _HEAD[language].format(
        version=content.versions["mikas"],
        passports=_KEPT[language][not content.measured["passports_consent"]],
        memory=_READ[language][_kept_of_memory(content)],
    )
    lines = [
        f"{answer.title.to(language)} ({', '.join(answer.clauses)}): "
        f"{verdict_word(answer, language)}: {answer.text.to(language)}"
        for answer in content.answers
    ]
    return "\n".join([head, *lines])
