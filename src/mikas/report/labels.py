"""The fixed texts of the page, by name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from mikas.i18n import Language, Text

LABELS: Final = {
    "title": Text("Engine report", "Отчёт о двигателе"),
    "car": Text("Car", "Машина"),
    "plate": Text("Number plate", "Госномер"),
    "mileage": Text("Mileage", "Пробег"),
    "km": Text("{count} km", "{count} км"),
    "workshop": Text("Workshop", "Мастерская"),
    "unit": Text("Control unit", "Блок управления"),
    "model": Text("Model", "Модель"),
    "program": Text("Program", "Программа"),
    "data": Text("Calibration", "Калибровка"),
    "not_reported": Text("not reported by the unit", "блок не сообщает"),
    "not_asked": Text("not read", "не считывалось"),
    "of_recording": Text("From the recording", "По записи"),
    "live": Text("measured on the connected car", "измерено на подключённой машине"),
    "live_virtual": Text("measured on a virtual car", "измерено на виртуальном автомобиле"),
    "virtual": Text("a virtual car", "виртуальный автомобиль"),
    "alarms": Text("Alarms", "Тревоги"),
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
    "frames": Text("Freeze frames", "Стоп-кадры"),
    "then": Text("Then", "Тогда"),
    "in_between": Text("In between", "За этот промежуток"),
    "then_range": Text(
        "The values are those of the later time, with the lowest and the highest in between.",
        "Значения — на более позднее время, с пределами за этот промежуток.",
    ),
    "values": Text("Values at warm idle", "Значения на прогретом холостом ходу"),
    "value": Text("Value", "Параметр"),
    "median": Text("Median", "Медиана"),
    "spread": Text("90 % within", "90 % в пределах"),
    "band": Text("Normal", "Норма"),
    "mark": Text("Rating", "Оценка"),
    "within_band": Text("{share} of the readings", "{share} замеров"),
    "sensor_fault": Text(
        "Not rated: the sensor's circuit is faulty (fault {codes}), the unit may use a substitute "
        "value.",
        "Без оценки: неисправна цепь датчика (ошибка {codes}), блок может подставлять расчётное "
        "значение.",
    ),
    "too_few": Text(
        "Not rated: too few readings at warm idle ({count}).",
        "Без оценки: слишком мало замеров на прогретом холостом ходу ({count}).",
    ),
    "related": Text("See also stored fault {codes}.", "См. также ошибку {codes}."),
    "substitute": Text("perhaps a substitute value", "возможно, подставленное значение"),
    "others_idle": Text(
        "Also measured at warm idle; not rated, as no normal range is known",
        "Также измерено на прогретом холостом ходу; без оценки: нормы неизвестны",
    ),
    "others_whole": Text(
        "Over the whole time; not rated without warm idle",
        "За всё время; без прогретого холостого хода не оценивается",
    ),
    "set_share": Text("on in {share} of the readings", "вкл. в {share} замеров"),
    "charts": Text("Charts", "Графики"),
    "legend_band": Text(
        "Shaded: normal range at warm idle.", "Полоса: норма на прогретом холостом ходу."
    ),
    "legend_idle": Text("Bar at the bottom: warm idle.", "Черта внизу: прогретый холостой ход."),
    "legend_gaps": Text("Grey: no data.", "Серое поле: нет данных."),
    "how": Text("How it was measured", "Как измерено"),
    "length": Text("Length", "Длительность"),
    "samples": Text("Samples", "Замеры"),
    "sample_rate": Text("{count}, {rate} readings/s", "{count}, {rate} опр/с"),
    "method": Text("Method", "Способ опроса"),
    "adapter": Text("Adapter", "Адаптер"),
    "echo": Text("Echo", "Эхо"),
    "yes": Text("yes", "есть"),
    "no": Text("no", "нет"),
    "gaps": Text("Gaps", "Пропуски"),
    "gaps_none": Text("none", "нет"),
    "gaps_unknown": Text("not noted in this file", "в этом файле не отмечены"),
    "clock": Text("Clock", "Часы"),
    "errors": Text("Line errors", "Ошибки линии"),
    "since_connecting": Text("{count} since connecting", "{count} с начала соединения"),
    "other_methods": Text("others before", "до этого другие"),
    "catalog": Text("Catalog", "Каталог параметров"),
    "idle": Text("Warm idle", "Прогретый холостой ход"),
    "unknown": Text("What remains unknown", "Чего узнать не удалось"),
    "made_by": Text("Made by {program}", "Создано программой {program}"),
    "date": Text("%d.%m.%Y %H:%M", "%d.%m.%Y %H:%M"),
    "no_date": Text("date unknown", "дата неизвестна"),
}


class Labels:
    """The texts in one language: `labels("gaps")`, `labels("sample_rate", count=3)`."""

    def __init__(self, language: Language, texts: Mapping[str, Text] = LABELS) -> None:
        self.language: Language = language
        self._texts = texts

    def __call__(self, name: str, **fields: object) -> str:
        text = self._texts[name].to(self.language)
        return text.format(**fields) if fields else text
