"""The words of the dissector, by the key that its Lua files use."""

from __future__ import annotations

from typing import Final

from mikas.i18n import Text

LABELS: Final[dict[str, Text]] = {
    "protocol": Text("Mikas K-Line", "Микас K-Line"),
    "tester": Text("Tester", "Тестер"),
    "unit": Text("ECU", "Блок"),
    # Frames (§2)
    "frame": Text("Frame", "Кадр"),
    "direction": Text("Direction", "Направление"),
    "sent": Text("sent", "послано"),
    "received": Text("received", "принято"),
    "echo": Text("Echo", "Эхо"),
    "echo_of": Text("Echo of packet", "Эхо пакета"),
    "wire": Text("On the wire", "На линии"),
    "body": Text("Body, without stuffing", "Тело без замены байтов"),
    "checksum": Text("Checksum", "Контрольная сумма"),
    "raw_checksum": Text(
        "Checksum sent without stuffing (D3)", "Контрольная сумма без замены (D3)"
    ),
    "irregular": Text("Irregular escape (D4)", "Необычная замена байта (D4)"),
    "begin": Text("Begins in packet", "Начинается в пакете"),
    "finish": Text("Ends in packet", "Кончается в пакете"),
    "continued": Text("Completed in packet", "Заканчивается в пакете"),
    "part": Text("Part of a frame", "Часть кадра"),
    "reassembled": Text("Whole frame", "Кадр целиком"),
    "noise": Text("line noise", "помехи на линии"),
    "damage": Text("Damage", "Повреждение"),
    "damage_data": Text("Damaged bytes", "Повреждённые байты"),
    # Requests and responses (§3)
    "command": Text("Command", "Команда"),
    "name": Text("Name in the source", "Имя в источнике"),
    "meaning": Text("Meaning", "Значение"),
    "request": Text("Answers the request", "Ответ на запрос"),
    "doubt": Text("Answers no request", "Не ответ на запрос"),
    "request_in": Text("Request in packet", "Запрос в пакете"),
    "response_in": Text("Response in packet", "Ответ в пакете"),
    "response_time": Text("Time since the request", "Время от запроса"),
    "interval": Text("Time since the previous response", "Время от предыдущего ответа"),
    "address": Text("Address", "Адрес"),
    "count": Text("Number of bytes", "Число байтов"),
    "value": Text("Byte", "Байт"),
    "data": Text("Data", "Данные"),
    "code": Text("Parameter", "Параметр"),
    "model": Text("Model", "Модель"),
    "fault_count": Text("Number of faults", "Число ошибок"),
    "fault": Text("Fault", "Ошибка"),
    "unknown_fault": Text("its meaning is not known", "расшифровки нет"),
    "confidence_confirmed": Text("confirmed", "подтверждено"),
    "confidence_reported": Text("one source", "один источник"),
    "confidence_unconfirmed": Text("unconfirmed", "не подтверждено"),
    "confidence_unknown": Text("unknown", "неизвестно"),
    "passport": Text("Passport", "Паспорт"),
    "result": Text("Result", "Результат"),
    # Expert information
    "expert_checksum": Text("wrong checksum", "неверная контрольная сумма"),
    "expert_too_long": Text("no end in sight", "слишком длинно"),
    "expert_unfinished": Text("unfinished", "не закончено"),
    "expert_irregular": Text("irregular escape", "необычная замена байта"),
    "expert_unfit": Text("the response does not fit", "ответ не подходит к запросу"),
    "expert_refused": Text("refused", "отказ"),
    "expert_doubt": Text("not trusted", "не в счёт"),
    "expert_unknown": Text("unknown request", "неизвестный запрос"),
    "expert_fault": Text("stored fault", "запомненная ошибка"),
    "expert_no_direction": Text(
        "not said whether it was sent or received", "не указано, послано или принято"
    ),
    "expert_cut": Text("recorded without its last bytes", "записано без последних байтов"),
    # Instruments beside the unit
    "instrument": Text("instrument", "прибор"),
    "instrument_line": Text("Line", "Строка"),
    "instrument_bytes": Text("Bytes", "Байты"),
    "instrument_unfinished": Text("goes on in the next packet", "продолжение в следующем пакете"),
    # Preferences
    "interpretation": Text("Interpretation", "Толкование"),
    "interpretation_help": Text(
        "How the doubtful places of the protocol's source are interpreted",
        "Как толковать сомнительные места описания протокола",
    ),
    "baud": Text("Bit rate", "Скорость, бит/с"),
    "baud_help": Text(
        "Bits a second on the line: how long a byte lasts decides over a silence",
        "Бит в секунду на линии: по длительности байта определяется пауза",
    ),
}
