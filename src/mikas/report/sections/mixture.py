"""The mixture: what the unit aims at against what a meter measures, by engine speed and load."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from markupsafe import Markup

from mikas.drives.mixture import (
    AGREES,
    ENOUGH,
    LEANEST,
    SCATTERS,
    MixtureCell,
    MixtureComparison,
    MixtureVerdict,
)
from mikas.i18n import Language, Text
from mikas.recording.formatting import digits
from mikas.report.findings import Findings
from mikas.report.sections.section import PageSection, items, paragraph, table

_MOST: Final = 16  # cells, each with a row
TITLE: Final = Text("Mixture: aimed at and measured", "Смесь: заданная и измеренная")
_LOADS: Final = {
    "FILLING": Text("Filling, %", "Наполнение, %"),
    "THR": Text("Throttle, %", "Дроссель, %"),
}
_HEAD: Final = (
    Text("Aimed at (VALF)", "Заданная (VALF)"), Text("Measured (λ)", "Измеренная (λ)"),
    Text("Difference (of 80 % of the values)", "Разница (у 80 % значений)"),
    Text("Values", "Значений"), Text("Verdict", "Вывод"),
)  # fmt: skip
_SPEED: Final = Text("rpm", "об/мин")
VERDICTS: Final = {
    MixtureVerdict.AGREES: Text("as aimed at", "как задано"),
    MixtureVerdict.LEANER: Text("leaner", "беднее"),
    MixtureVerdict.RICHER: Text("richer", "богаче"),
    MixtureVerdict.SCATTERS: Text("scatters: no verdict", "разброс: вывода нет"),
}
_NONE: Final = Text(
    "No cell of speed and load has {enough} values with both steady: drive steadily for some "
    "seconds at each speed.",
    "Ни в одной ячейке нет {enough} значений при постоянных оборотах и нагрузке: "
    "держите каждый режим несколько секунд.",
)
_ALL_AGREE: Final = Text(
    "In all cells with enough values ({count}) the measured mixture is the one that the unit aims "
    "at, within {most} %.",
    "Во всех ячейках, где значений достаточно ({count}), измеренная смесь — та, что задаёт блок, с "
    "точностью {most} %.",
)
_SOME: Final = Text(
    "Of {count} cells with enough values, in {leaner} the measured mixture is leaner than the unit "
    "aims at by more than {most} %, in {richer} it is richer, in {scattered} it scatters.",
    "Из {count} ячеек, где значений достаточно, в {leaner} измеренная смесь беднее заданной больше "
    "чем на {most} %, в {richer} — богаче, в {scattered} — разброс.",
)
_DOUBT: Final = Text(
    "A meter is good to 2 to 3 %; a leak of the exhaust before its sensor reads as leaner. VALF is "
    "what the unit aims at, by its own sensors. A scatter of more than {scatter} % is no verdict.",
    "Точность прибора — 2–3 %; неплотность выпуска перед его датчиком читается как беднее. VALF — "
    "это цель блока, по его собственным датчикам. Разброс больше {scatter} % — вывода нет.",
)
_LEFT_OUT: Final = Text(
    "Left out: {unsteady} measured values while speed or load changed, {lean} above λ {leanest} "
    "(fuel cut off, or a cylinder that misses), cells with fewer than {enough} values: {few}.",
    "Не вошли: {unsteady} значений прибора, когда менялись обороты или нагрузка, {lean} выше λ "
    "{leanest} (отсечка топлива или пропуски), ячейки, где меньше {enough} значений: {few}.",
)
_MORE: Final = Text("Cells that are not shown: {count}.", "Не показано ячеек: {count}.")


def mixture_section(found: Findings, language: Language) -> PageSection | None:
    """Return the section; None without a λ meter, or without what the unit aims at."""
    mixture = found.subject.mixture
    if mixture is None:
        return None
    parts = [paragraph(_summary(mixture).to(language))]
    if mixture.judged:
        shown = sorted(mixture.judged, key=lambda cell: -cell.count)[:_MOST]
        rows = (_row(cell, language) for cell in mixture.judged if cell in shown)
        head = (_SPEED, _LOADS[mixture.load], *_HEAD)
        parts.append(table((each.to(language) for each in head), rows))
    parts.append(items(text.to(language) for text in _notes(mixture)))
    return PageSection(TITLE.to(language), Markup("").join(parts))


def _summary(mixture: MixtureComparison) -> Text:
    judged = mixture.judged
    if not judged:
        return _NONE.filled(enough=ENOUGH)
    verdicts = [cell.verdict for cell in judged]
    if all(each is MixtureVerdict.AGREES for each in verdicts):
        return _ALL_AGREE.filled(count=len(judged), most=digits(AGREES, 0))
    return _SOME.filled(
        count=len(judged),
        most=digits(AGREES, 0),
        leaner=verdicts.count(MixtureVerdict.LEANER),
        richer=verdicts.count(MixtureVerdict.RICHER),
        scattered=verdicts.count(MixtureVerdict.SCATTERS),
    )


def _notes(mixture: MixtureComparison) -> Iterator[Text]:
    if len(mixture.judged) > _MOST:
        yield _MORE.filled(count=len(mixture.judged) - _MOST)
    yield _LEFT_OUT.filled(
        unsteady=mixture.unsteady,
        lean=mixture.lean,
        leanest=digits(LEANEST, 1),
        enough=ENOUGH,
        few=len(mixture.cells) - len(mixture.judged),
    )
    yield _DOUBT.filled(scatter=digits(SCATTERS, 0))


def _row(cell: MixtureCell, language: Language) -> tuple[str, ...]:
    ends = f"{_signed(cell.low, language)} … {_signed(cell.high, language)}"
    return (
        f"{cell.rpm[0]:.0f}–{cell.rpm[1]:.0f}",
        f"{cell.load[0]:.0f}–{cell.load[1]:.0f}",
        digits(cell.aimed, 2).to(language),
        digits(cell.measured, 2).to(language),
        f"{_signed(cell.difference, language)} % ({ends})",
        str(cell.count),
        VERDICTS[cell.verdict].to(language),
    )


def _signed(value: float, language: Language) -> str:
    shown = digits(value, 1).to(language)
    return f"+{shown}" if round(value, 1) > 0 else shown
