"""The list of commands: where each is defined, and its line in the help.

A command's module is imported only when the command is called: `mikas --help` must appear at once.
A new command is a function with `@command` in a module of its own, and an entry here.
"""

from mikas.i18n import Text

_HERE = "mikas.cli.commands"
_UNIT, _MEMORY, _RECORDINGS = f"{_HERE}.unit", f"{_HERE}.memory", f"{_HERE}.recordings"
COMMANDS: dict[str, tuple[str, Text]] = {
    "ports": (
        f"{_HERE}.ports:ports",
        Text("list the adapters plugged in", "показать подключённые адаптеры"),
    ),
    "doctor": (
        f"{_HERE}.doctor:doctor",
        Text("check the connection step by step", "проверить связь по шагам"),
    ),
    "info": (
        f"{_UNIT}.info:info",
        Text("model, passports, supported commands", "модель, паспорта, команды блока"),
    ),
    "params": (
        f"{_UNIT}.params:params",
        Text("list all parameters (needs no port)", "показать все параметры (порт не нужен)"),
    ),
    "read": (f"{_UNIT}.read:read", Text("read parameters once", "прочитать параметры один раз")),
    "watch": (f"{_HERE}.watch:watch", Text("live table of values", "таблица текущих значений")),
    "log": (f"{_HERE}.log:log", Text("record to a file", "запись в файл")),
    "faults": (
        f"{_UNIT}.faults:faults",
        Text("stored faults; `faults erase` erases them", "ошибки; сброс: `faults erase`"),
    ),
    "write": (f"{_UNIT}.write:write", Text("write a parameter", "записать параметр")),
    "mem": (
        f"{_MEMORY}.group:mem",
        Text(
            "read, write, dump and compare memory", "память блока: чтение, запись, дамп, сравнение"
        ),
    ),
    "raw": (f"{_UNIT}.raw:raw", Text("send any request", "отправить любой запрос")),
    "decode": (
        f"{_RECORDINGS}.decode:decode",
        Text(
            "show a capture frame by frame (needs no port)",
            "показать запись по кадрам (порт не нужен)",
        ),
    ),
    "export": (
        f"{_RECORDINGS}.export:export",
        Text(
            "export a recording for other programs (needs no port)",
            "экспорт записи для других программ (порт не нужен)",
        ),
    ),
    "report": (
        f"{_RECORDINGS}.report:report",
        Text(
            "a report on the car, from a recording or measured now",
            "отчёт о машине: по записи или по измерению сейчас",
        ),
    ),
    "sim": (
        f"{_HERE}.sim:sim",
        Text("a virtual ECU for other programs", "виртуальный блок для других программ"),
    ),
    "dash": (
        f"{_HERE}.dash:dash",
        Text("the dashboard in the browser", "панель в браузере"),
    ),
    "demo": (
        f"{_HERE}.dash:demo",
        Text("the dashboard with a virtual car", "панель с виртуальным автомобилем"),
    ),
}
MEMORY_COMMANDS: dict[str, tuple[str, Text]] = {
    "read": (f"{_MEMORY}.cells:read", Text("hex dump of some bytes", "показать байты")),
    "write": (
        f"{_MEMORY}.cells:write",
        Text("write bytes and read them back", "записать байты и проверить чтением"),
    ),
    "dump": (f"{_MEMORY}.files:dump", Text("save a memory space to a file", "считать дамп в файл")),
    "verify": (
        f"{_MEMORY}.files:verify",
        Text("compare a file with the unit", "сравнить дамп с памятью блока"),
    ),
    "diff": (
        f"{_MEMORY}.files:diff",
        Text("compare two dumps (needs no port)", "сравнить два дампа (порт не нужен)"),
    ),
    "goto": (
        f"{_MEMORY}.cells:goto",
        Text("jump to an address: dangerous", "переход по адресу: опасно"),
    ),
}
"""The commands of `mikas mem`."""
