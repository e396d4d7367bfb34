"""The fixed texts of the page, by name."""

from __future__ import annotations

from typing import Final

from mikas.i18n import Language, Text

_LABELS: Final = {
    "title": Text("Engine report", "Отчёт о двигателе"),
    "unit": Text("Control unit", "Блок управления"),
    "model": Text("Model", "Модель"),
    "program": Text("Program", "Программа"),
    "data": Text("Calibration", "Калибровка"),
    "not_reported": Text("not reported by the unit", "блок не сообщает"),
    "not_asked": Text("not read", "не считывалось"),
    "of_recording": Text("From the recording", "По записи"),
    "live": Text("measured live", "измерено на подключённой машине"),
    "faults": Text("Stored faults", "Ошибки в памяти блока"),
    "faults_none": Text("No faults are stored.", "Ошибок нет."),
    "faults_unread": Text("Not read in this session.", "В этом сеансе не считывались."),
    "faults_read": Text("Read {when}.", "Считаны {when}."),
    "erased": Text("Erased {when}:", "Сброшены {when}:"),
    "gone": Text(
        "Stored before, no longer stored {when} (no erase command was recorded):",
        "Были в памяти, {when} их уже нет (команды сброса в записи нет):",
    ),
    "drive_again": Text(
        "Drive as usual, then read the faults again: a fault that comes back still has its cause.",
        "Поездите как обычно и считайте ошибки снова: если ошибка вернулась, причина не устранена.",
    ),
    "check": Text("Check:", "Проверить:"),
    "no_text": Text("unknown fault number", "неизвестный номер ошибки"),
    "message": Text("a message, not a fault", "сообщение, не ошибка"),
    "measured": Text("measured", "измерено"),
    "values": Text("Values at warm idle", "Значения на прогретом холостом ходу"),
    "value": Text("Value", "Параметр"),
    "median": Text("Median", "Медиана"),
    "spread": Text("90 % within", "90 % в пределах"),
    "band": Text("Normal", "Норма"),
    "mark": Text("Rating", "Оценка"),
    "within_band": Text("{share} of the time", "{share} времени"),
    "fault_bears": Text(
        "Stored fault {codes} concerns this value: the unit may use a substitute value.",
        "К этому параметру относится ошибка {codes}: блок может подставлять расчётное значение.",
    ),
    "others_idle": Text(
        "Also measured at warm idle; not rated, as no normal range is known",
        "Также измерено на прогретом холостом ходу; без оценки: нормы неизвестны",
    ),
    "others_whole": Text(
        "Over the whole time; not rated, as there was no warm idle",
        "За всё время; без оценки: прогретого холостого хода не было",
    ),
    "set_share": Text("on for {share} of the time", "вкл. {share} времени"),
    "charts": Text("Charts", "Графики"),
    "legend": Text(
        "Shaded: normal range at warm idle. Bar at the bottom: warm idle. Grey: no data.",
        "Полоса: норма на прогретом холостом ходу. Черта внизу: прогретый холостой ход. Серое "
        "поле: нет данных.",
    ),
    "how": Text("How it was measured", "Как измерено"),
    "length": Text("Length", "Длительность"),
    "samples": Text("Samples", "Отсчёты"),
    "sample_rate": Text("{count}, {rate} readings/s", "{count}, {rate} опр/с"),
    "method": Text("Method", "Способ опроса"),
    "adapter": Text("Adapter", "Адаптер"),
    "echo": Text("Echo", "Эхо"),
    "yes": Text("yes", "есть"),
    "no": Text("no", "нет"),
    "gaps": Text("Gaps", "Пропуски"),
    "gaps_none": Text("none", "нет"),
    "errors": Text("Line errors", "Ошибки линии"),
    "catalog": Text("Catalog", "Каталог параметров"),
    "idle": Text("Warm idle", "Прогретый холостой ход"),
    "unknown": Text("What remains unknown", "Чего узнать не удалось"),
    "made_by": Text("Made by {program}", "Создано программой {program}"),
    "date": Text("%d.%m.%Y %H:%M", "%d.%m.%Y %H:%M"),
    "no_date": Text("date unknown", "дата неизвестна"),
}
NAMES: Final = frozenset(_LABELS)


class Labels:
    """The texts in one language: `labels("gaps")`, `labels("sample_rate", count=3)`."""

    def __init__(self, language: Language) -> None:
        self._language = language

    def __call__(self, name: str, **fields: object) -> str:
        text = _LABELS[name].to(self._language)
        return text.format(**fields) if fields else text
