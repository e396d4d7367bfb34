"""The list of commands: the module of each, and its line in the help.

A command's module is imported only when the command is called: `mikas --help` must appear at once.
A new command is a function with `@command`, which gives it its name, and an entry here.
"""

from mikas.i18n import Text


def _command(module: str, en: str, ru: str) -> tuple[str, Text]:
    return f"{__name__}.{module}", Text(en, ru)


COMMANDS: dict[str, tuple[str, Text]] = {
    "ports": _command("ports", "list the adapters plugged in", "показать подключённые адаптеры"),
    "doctor": _command("doctor", "check the connection step by step", "проверить связь по шагам"),
    "info": _command(
        "unit.info", "model, passports, supported commands", "модель, паспорта, команды блока"
    ),
    "params": _command(
        "unit.parameters",
        "list all parameters (needs no port)",
        "показать все параметры (порт не нужен)",
    ),
    "read": _command("unit.parameters", "read parameters once", "прочитать параметры один раз"),
    "scan": _command(
        "unit.scan",
        "which codes the unit answers; a catalog file to start from",
        "на какие коды отвечает блок; заготовка каталога",
    ),
    "watch": _command("watch", "live table of values", "таблица текущих значений"),
    "log": _command("log", "record to a file", "запись в файл"),
    "publish": _command(
        "publish",
        "live values to an MQTT broker: Home Assistant, Node-RED",
        "текущие значения на брокер MQTT: Home Assistant, Node-RED",
    ),
    "faults": _command(
        "unit.faults", "stored faults; `faults erase` erases them", "ошибки; сброс: `faults erase`"
    ),
    "write": _command("unit.parameters", "write a parameter", "записать параметр"),
    "list": _command(
        "unit.parameter_list",
        "the unit's own list: set it (64), read it (63)",
        "список в самом блоке: задать (64), прочитать (63)",
    ),
    "mem": _command(
        "memory",
        "read, write, dump and compare memory",
        "память блока: чтение, запись, дамп, сравнение",
    ),
    "raw": _command("unit.raw", "send any request", "отправить любой запрос"),
    "decode": _command(
        "recordings.export",
        "show a capture frame by frame (needs no port)",
        "показать запись по кадрам (порт не нужен)",
    ),
    "export": _command(
        "recordings.export",
        "export a recording for other programs (needs no port)",
        "экспорт записи для других программ (порт не нужен)",
    ),
    "find": _command(
        "recordings.find",
        "find the moments of a recording at which a condition holds (needs no port)",
        "найти в записи моменты, когда выполняется условие (порт не нужен)",
    ),
    "report": _command(
        "recordings.report",
        "a report on the car, from a recording or measured now",
        "отчёт о машине: по записи или по измерению сейчас",
    ),
    "wireshark": _command(
        "recordings.decoders",
        "a plugin that shows recordings in Wireshark (needs no port)",
        "плагин Wireshark: записи по кадрам (порт не нужен)",
    ),
    "sigrok": _command(
        "recordings.decoders",
        "the decoder for sigrok and PulseView (needs no port)",
        "декодер для sigrok и PulseView (порт не нужен)",
    ),
    "fleet": _command(
        "fleet",
        "many recordings as one dataset: add, ask by SQL, report (needs no port)",
        "много записей как один набор: собрать, спросить на SQL, отчёт (порт не нужен)",
    ),
    "test": _command(
        "guided_test",
        "a guided test, step by step, with a verdict",
        "проверка по шагам, с заключением",
    ),
    "sim": _command(
        "sim", "a virtual ECU for other programs", "виртуальный блок для других программ"
    ),
    "dash": _command("dash", "the dashboard in the browser", "панель в браузере"),
    "demo": _command(
        "dash", "the dashboard with a virtual car", "панель с виртуальным автомобилем"
    ),
}
MEMORY_COMMANDS: dict[str, tuple[str, Text]] = {
    "read": _command("memory.cells", "hex dump of some bytes", "показать байты"),
    "write": _command(
        "memory.cells", "write bytes and read them back", "записать байты и проверить чтением"
    ),
    "dump": _command("memory.files", "save a memory space to a file", "считать дамп в файл"),
    "restore": _command(
        "memory.files",
        "write a dump back: only what differs",
        "записать дамп обратно: только отличия",
    ),
    "verify": _command(
        "memory.files", "compare a file with the unit", "сравнить дамп с памятью блока"
    ),
    "diff": _command(
        "memory.files", "compare two dumps (needs no port)", "сравнить два дампа (порт не нужен)"
    ),
    "goto": _command("memory.cells", "jump to an address: dangerous", "переход по адресу: опасно"),
}
"""The commands of `mikas mem`."""

LIST_COMMANDS: dict[str, tuple[str, Text]] = {
    "set": _command(
        "unit.parameter_list", "set the parameters of the list", "задать параметры списка"
    ),
    "read": _command("unit.parameter_list", "read the list", "прочитать список"),
}
"""The commands of `mikas list`."""

FLEET_COMMANDS: dict[str, tuple[str, Text]] = {
    "add": _command("fleet.add", "add recordings to a dataset", "добавить записи в набор"),
    "sql": _command("fleet.sql", "ask a dataset by SQL", "запрос к набору на SQL"),
    "report": _command(
        "fleet.report", "a report on all cars of a dataset", "отчёт по всем машинам набора"
    ),
}
"""The commands of `mikas fleet`."""
