"""The list of commands: the module of each, and its line in the help.

A command's module is imported only when the command is called: `mikas --help` must appear at once.
A new command is a function with `@command`, which gives it its name, and an entry here.
"""

from mikas.i18n import Text


def home(module: str, en: str, ru: str) -> tuple[str, Text]:
    """Return the name of a command's module, which is given below this package, and the line."""
    return f"{__name__}.{module}", Text(en, ru)


COMMANDS: dict[str, tuple[str, Text]] = {
    "demo": home("dash", "the dashboard with a virtual car", "панель с виртуальным автомобилем"),
    "ports": home("ports", "list the adapters plugged in", "показать подключённые адаптеры"),
    "doctor": home("doctor", "check the connection step by step", "проверить связь по шагам"),
    "dash": home("dash", "the dashboard in the browser", "панель в браузере"),
    "params": home(
        "unit.parameters",
        "list all parameters (needs no port)",
        "показать все параметры (порт не нужен)",
    ),
    "read": home("unit.parameters", "read parameters once", "прочитать параметры один раз"),
    "watch": home("watch", "live table of values", "таблица текущих значений"),
    "log": home("log", "record to a file", "запись в файл"),
    "publish": home(
        "publish",
        "live values to an MQTT broker: Home Assistant, Node-RED",
        "текущие значения на брокер MQTT: Home Assistant, Node-RED",
    ),
    "test": home(
        "guided_test",
        "a guided test, step by step, with a verdict",
        "проверка по шагам, с заключением",
    ),
    "info": home(
        "unit.info", "model, passports, supported commands", "модель, паспорта, команды блока"
    ),
    "faults": home(
        "unit.faults", "stored faults; `faults erase` erases them", "ошибки; сброс: `faults erase`"
    ),
    "write": home("unit.parameters", "write a parameter", "записать параметр"),
    "co": home(
        "unit.co",
        "set the idle CO by a gas analyser or a λ meter, step by step",
        "отрегулировать СО холостого хода по газоанализатору или лямбда-прибору, по шагам",
    ),
    "list": home(
        "groups",
        "the unit's own list: set it (64), read it (63)",
        "список в самом блоке: задать (64), прочитать (63)",
    ),
    "mem": home(
        "groups",
        "read, write, dump and compare memory",
        "память блока: чтение, запись, дамп, сравнение",
    ),
    "raw": home("unit.raw", "send any request", "отправить любой запрос"),
    "scan": home(
        "unit.scan",
        "which codes the unit answers; a catalog file to start from",
        "на какие коды отвечает блок; заготовка каталога",
    ),
    "evidence": home(
        "unit.evidence",
        "what clauses, channels and faults rest on (needs no port)",
        "на чём держатся пункты, каналы и ошибки (порт не нужен)",
    ),
    "survey": home(
        "unit.survey",
        "help the project: survey a real unit in ten minutes, reads only",
        "помочь проекту: обследовать настоящий блок за десять минут, только чтение",
    ),
    "report": home(
        "recordings.report",
        "a report on the car, from a recording or measured now",
        "отчёт о машине: по записи или по измерению сейчас",
    ),
    "causes": home(
        "recordings.causes",
        "what is wrong with the car, ranked, from recordings or measured now",
        "причины неисправности: по записям или по измерению сейчас",
    ),
    "find": home(
        "recordings.find",
        "find the moments of a recording at which a condition holds (needs no port)",
        "найти в записи моменты, когда выполняется условие (порт не нужен)",
    ),
    "trip": home(
        "recordings.trip",
        "drives of a recording: fuel, distance, idling (needs no port)",
        "поездки в записи: топливо, путь, холостой ход (порт не нужен)",
    ),
    "pull": home(
        "recordings.pull",
        "power and torque from a full-throttle pull in a recording (needs no port)",
        "мощность и момент по разгону в записи (порт не нужен)",
    ),
    "export": home(
        "recordings.export",
        "export a recording for other programs (needs no port)",
        "экспорт записи для других программ (порт не нужен)",
    ),
    "split": home(
        "recordings.split",
        "make a file of each car from a recording of several (needs no port)",
        "сделать из записи нескольких машин по файлу на каждую (порт не нужен)",
    ),
    "decode": home(
        "recordings.export",
        "show a capture frame by frame (needs no port)",
        "показать запись по кадрам (порт не нужен)",
    ),
    "fleet": home(
        "groups",
        "many recordings as one dataset: add, ask by SQL, report (needs no port)",
        "много записей как один набор: собрать, спросить на SQL, отчёт (порт не нужен)",
    ),
    "sim": home("sim", "a virtual ECU for other programs", "виртуальный блок для других программ"),
    "wireshark": home(
        "recordings.decoders",
        "a plugin that shows recordings in Wireshark (needs no port)",
        "плагин Wireshark: записи по кадрам (порт не нужен)",
    ),
    "sigrok": home(
        "recordings.decoders",
        "the decoder for sigrok and PulseView (needs no port)",
        "декодер для sigrok и PulseView (порт не нужен)",
    ),
    "help": home(
        "help", "the help of a command: mikas help read", "справка по команде: mikas help read"
    ),
    "completion": home(
        "completion",
        "completion of commands by the shell's Tab key",
        "дополнение команд в оболочке клавишей Tab",
    ),
}
TITLES: dict[str, Text] = {
    "demo": Text("First steps", "С чего начать"),
    "params": Text("Values", "Значения"),
    "info": Text("The unit", "Блок"),
    "report": Text("Recordings", "Записи"),
    "sim": Text("Other programs", "Другие программы"),
    "help": Text("Help", "Справка"),
}
"""The titles in the help's list, each above the command of the name."""
