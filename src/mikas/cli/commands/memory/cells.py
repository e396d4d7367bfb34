"""`mikas mem read`, `write`, `goto`: single cells of the unit's memory."""

from __future__ import annotations

from collections.abc import Iterator

from mikas.cli.click_extensions import SURE, YES, argument, command
from mikas.cli.context import CommandContext, check_sure
from mikas.cli.options.common import RELEARN
from mikas.cli.options.parameter_types import OneOf, hex_address, hex_bytes, size_in_bytes
from mikas.client import Change
from mikas.commands.base import check_range
from mikas.i18n import Text

SPACE = OneOf(("ram", "xram", "code", "sfr"))


@command(
    en="Shows COUNT bytes (1) from ADDR. Addresses are hex. SPACE: ram, xram, code, sfr.",
    ru="Показывает COUNT байт (1) с адреса ADDR. Адреса шестнадцатеричные. SPACE: ram, xram, "
    "code, sfr.",
    examples=("mikas mem read ram 40", "mikas mem read xram 0x1000 64 --json"),
)
@argument("space", "SPACE", type=SPACE)
@argument("address", "ADDR", type=hex_address)
@argument("count", "[COUNT]", type=size_in_bytes, default="1")
@RELEARN
def read(context: CommandContext, space: str, address: int, count: int) -> None:
    check_range(space, address, count)
    with context.ecu() as ecu:
        data = ecu.memory[space].read_block(address, count)
    context.output.result(
        {"space": space, "address": address, "data": data}, "\n".join(_hexdump(data, address))
    )


@command(
    en="Writes the bytes HEX from ADDR: asks first, reads them back, adds them to the journal. "
    "A unit that lacks single-byte commands gets blocks, one that lacks blocks single bytes. "
    "Writing CODE can make the unit unusable.",
    ru="Записывает байты HEX с адреса ADDR: спрашивает подтверждение, проверяет чтением, ведёт "
    "журнал. Если у блока нет побайтовых команд, пишет блочными, и наоборот. После записи в "
    "CODE блок может перестать работать.",
    examples=("mikas mem write ram 40 0D", "mikas mem write xram 1000 AABB --yes"),
)
@argument("space", "SPACE", type=SPACE)
@argument("address", "ADDR", type=hex_address)
@argument("data", "HEX", type=hex_bytes)
@YES
@RELEARN
def write(context: CommandContext, space: str, address: int, data: bytes, *, yes: bool) -> None:
    check_range(space, address, len(data))
    ask = context.confirm(yes=yes)
    confirmed = False

    def confirm(change: Change) -> bool:
        nonlocal confirmed
        confirmed = ask(change)
        return confirmed

    try:
        with context.ecu(confirm) as ecu:
            written = ecu.memory[space].write_block(address, data)
    except KeyboardInterrupt:
        if confirmed:
            again = f"mikas mem read {space} {address:X} {len(data)}"
            context.output.print_note("")  # after the terminal's ^C
            context.say(
                f"Stopped: some of the bytes may be written. Read them: {again}. The journal has "
                "the bytes before.",
                f"Прервано: часть байтов могла быть записана. Прочтите их: {again}. Прежние "
                "байты есть в журнале.",
            )
        raise
    before, after = written.before.hex(" ").upper(), written.after.hex(" ").upper()
    context.output.result(
        {"space": space, "address": address, "before": written.before, "after": written.after},
        f"{space} {address:04X}: {before} → {after}",
    )


@command(
    en="Makes the ECU jump to ADDR. The most dangerous command: the unit executes the bytes at "
    "that address. Always asks; --yes alone is not enough.",
    ru="Переход блока на адрес ADDR. Самая опасная команда: блок выполнит то, что там записано. "
    "Всегда спрашивает подтверждение; одного --yes недостаточно.",
    examples=("mikas mem goto 8000",),
)
@argument("address", "ADDR", type=hex_address)
@YES
@SURE
def goto(context: CommandContext, address: int, *, yes: bool, sure: bool) -> None:
    jump = Text(f"jump to {address:04X}", f"переход на {address:04X}")
    check_sure(jump, yes=yes, sure=sure)
    check_range("code", address)
    with context.ecu(context.confirm(yes=yes)) as ecu:
        response = ecu.goto(address)
    if context.output.json:
        context.output.data({"address": address, "response": response or None})
    elif response:
        context.output.line(response.hex(" ").upper())
    else:
        context.say_sent()


def _hexdump(data: bytes, address: int) -> Iterator[str]:
    """Yield lines like `0040  45 6A 8F …  Ej…`, each from a multiple of 16, in code page 866."""
    end = address + len(data)
    for line in range(address - address % 16, end, 16):
        row = [data[at - address] if address <= at < end else None for at in range(line, line + 16)]
        cells = ["  " if byte is None else f"{byte:02X}" for byte in row]
        characters = "".join(" " if byte is None else _character(byte) for byte in row)
        yield f"{line:04X}  {' '.join(cells[:8])}  {' '.join(cells[8:])}  {characters.rstrip()}"


def _character(value: int) -> str:
    character = bytes([value]).decode("cp866")
    return character if character.isprintable() else "."
