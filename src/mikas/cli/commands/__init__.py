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
        Text("adapters that are plugged in", "какие адаптеры подключены"),
    ),
    "doctor": (
        f"{_HERE}.doctor:doctor",
        Text("finds out what is wrong with the connection", "находит, что не так со связью"),
    ),
    "info": (
        f"{_UNIT}.info:info",
        Text("model, passports, what this unit supports", "модель, паспорта, что блок умеет"),
    ),
    "params": (
        f"{_UNIT}.params:params",
        Text("every known parameter (needs no port)", "все известные параметры (порт не нужен)"),
    ),
    "read": (f"{_UNIT}.read:read", Text("one reading each", "прочесть параметры один раз")),
    "watch": (f"{_HERE}.watch:watch", Text("live table", "живая таблица")),
    "log": (f"{_HERE}.log:log", Text("record to a file", "записывать в файл")),
    "faults": (
        f"{_UNIT}.faults:faults",
        Text("stored faults; `faults erase` erases them", "ошибки; `faults erase` стирает их"),
    ),
    "write": (f"{_UNIT}.write:write", Text("write a parameter", "записать параметр")),
    "mem": (
        f"{_MEMORY}.group:mem",
        Text(
            "read, write, dump and compare memory", "память блока: чтение, запись, образ, сравнение"
        ),
    ),
    "raw": (f"{_UNIT}.raw:raw", Text("send any request", "послать любой запрос")),
    "decode": (
        f"{_RECORDINGS}.decode:decode",
        Text(
            "a capture, frame by frame (needs no port)",
            "показать запись линии по кадрам (порт не нужен)",
        ),
    ),
    "export": (
        f"{_RECORDINGS}.export:export",
        Text(
            "a recording as a table for other programs (needs no port)",
            "запись в виде таблицы для других программ (порт не нужен)",
        ),
    ),
    "report": (
        f"{_RECORDINGS}.report:report",
        Text(
            "a page on the car for its owner, of a recording or measured now",
            "страница о машине для её владельца: по записи или по измерению сейчас",
        ),
    ),
    "sim": (
        f"{_HERE}.sim:sim",
        Text("a virtual ECU for other programs", "виртуальный блок для других программ"),
    ),
    "dash": (
        f"{_HERE}.dash:dash",
        Text("the dashboard, in the browser", "панель в браузере"),
    ),
    "demo": (
        f"{_HERE}.demo:demo",
        Text("the dashboard with a virtual car", "панель с виртуальным автомобилем"),
    ),
}
MEMORY_COMMANDS: dict[str, tuple[str, Text]] = {
    "read": (f"{_MEMORY}.cells:read", Text("hex dump of some bytes", "показать байты")),
    "write": (
        f"{_MEMORY}.cells:write",
        Text("write bytes, and read them back", "записать байты и перечитать"),
    ),
    "dump": (f"{_MEMORY}.files:dump", Text("a space to a file", "пространство в файл")),
    "verify": (
        f"{_MEMORY}.files:verify",
        Text("compare a file with the unit", "сравнить файл с блоком"),
    ),
    "diff": (
        f"{_MEMORY}.files:diff",
        Text("compare two dumps (needs no port)", "сравнить два образа (порт не нужен)"),
    ),
    "goto": (
        f"{_MEMORY}.cells:goto",
        Text("jump to an address: dangerous", "переход по адресу: опасно"),
    ),
}
"""The commands of `mikas mem`."""
