"""The fixed words of the page, by name."""

from __future__ import annotations

from typing import Final

from mikas.i18n import Language, Text

_LABELS: Final = {
    "title": Text("Engine report", "Отчёт о двигателе"),
    "unit": Text("Control unit", "Блок управления"),
    "model": Text("Model", "Модель"),
    "program": Text("Program", "Программа"),
    "data": Text("Calibration", "Калибровка"),
    "not_told": Text("the unit does not tell", "блок не сообщает"),
    "not_asked": Text("not asked", "не спрашивали"),
    "of_recording": Text("From the recording", "По записи"),
    "live": Text("measured live", "измерено на связи с блоком"),
    "faults": Text("Stored faults", "Ошибки в памяти блока"),
    "faults_none": Text("No faults are stored.", "Ошибок нет."),
    "faults_unread": Text("They were not read in this session.", "В этом сеансе их не читали."),
    "faults_read": Text("Read {when}.", "Прочитаны {when}."),
    "erased": Text("Erased {when}:", "Стёрты {when}:"),
    "gone": Text(
        "Stored before, and no longer {when} (nobody was seen to erase them):",
        "Были в памяти, а {when} их уже нет (как их стирали, не видно):",
    ),
    "drive_again": Text(
        "Drive as usual, then read the faults again: one that comes back still has its cause.",
        "Поездите как обычно и прочитайте ошибки снова: если ошибка вернулась, причина осталась.",
    ),
    "check": Text("Check:", "Проверить:"),
    "no_text": Text("a number that our catalog does not have", "такого номера в каталоге нет"),
    "message": Text("a message, not a fault", "сообщение, не неисправность"),
    "measured": Text("measured", "измерено"),
    "values": Text("Values at warm idle", "Значения на прогретом холостом ходу"),
    "value": Text("Value", "Параметр"),
    "median": Text("Median", "Медиана"),
    "spread": Text("90 % within", "90 % в пределах"),
    "band": Text("Usual", "Норма"),
    "mark": Text("Mark", "Оценка"),
    "within_band": Text("{share} of the time", "{share} времени"),
    "fault_bears": Text(
        "A stored fault ({codes}) concerns it: the unit may work with a substitute.",
        "К нему относится ошибка ({codes}): блок может подставлять своё число.",
    ),
    "others_idle": Text(
        "Measured at warm idle as well; no band is known, so not judged",
        "Также измерено на прогретом холостом ходу; нормы неизвестны, поэтому без оценки",
    ),
    "others_whole": Text(
        "Over the whole time; not judged, since the engine was not seen at warm idle",
        "За всё время; без оценки, так как прогретого холостого хода не было",
    ),
    "set_share": Text("on for {share} of the time", "вкл. {share} времени"),
    "charts": Text("Course", "Ход измерения"),
    "legend": Text(
        "Shaded: the usual band at warm idle. Bar at the bottom: warm idle. Grey field: nothing "
        "came.",
        "Полоса: норма на прогретом холостом ходу. Черта внизу: прогретый холостой ход. Серое "
        "поле: данных не было.",
    ),
    "how": Text("How it was measured", "Как измерено"),
    "length": Text("Length", "Длительность"),
    "samples": Text("Samples", "Отсчёты"),
    "sample_rate": Text("{count}, {rate} a second", "{count}, {rate} в секунду"),
    "method": Text("Method", "Способ"),
    "adapter": Text("Adapter", "Адаптер"),
    "echo": Text("Echo", "Эхо"),
    "yes": Text("yes", "есть"),
    "no": Text("no", "нет"),
    "gaps": Text("Gaps", "Пропуски"),
    "gaps_none": Text("none", "нет"),
    "errors": Text("Line errors", "Ошибки линии"),
    "catalog": Text("Definitions", "Определения"),
    "idle": Text("Warm idle", "Прогретый холостой ход"),
    "unknown": Text("What could not be known", "Чего узнать не удалось"),
    "made_by": Text("Made by {program}", "Создано программой {program}"),
    "date": Text("%d.%m.%Y %H:%M", "%d.%m.%Y %H:%M"),
    "no_date": Text("date unknown", "дата неизвестна"),
}
NAMES: Final = frozenset(_LABELS)


class Labels:
    """The words in one language, filled in: `labels("gaps")`, `labels("sample_rate", count=3)`."""

    def __init__(self, language: Language) -> None:
        self._language = language

    def __call__(self, name: str, **fields: object) -> str:
        text = _LABELS[name].to(self._language)
        return text.format(**fields) if fields else text
