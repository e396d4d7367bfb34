"""`mikas mem`: the memory commands, one module for those on the unit, one for those on files."""

from __future__ import annotations

from mikas.cli.grammar import Group, common_options
from mikas.i18n import Text

_HERE = "mikas.cli.commands"

mem = Group(
    "mem",
    homes={
        "read": (f"{_HERE}.mem_cells:read", Text("hex dump of some bytes", "показать байты")),
        "write": (
            f"{_HERE}.mem_cells:write",
            Text("write bytes, and read them back", "записать байты и перечитать"),
        ),
        "dump": (f"{_HERE}.mem_files:dump", Text("a space to a file", "пространство в файл")),
        "verify": (
            f"{_HERE}.mem_files:verify",
            Text("compare a file with the unit", "сравнить файл с блоком"),
        ),
        "diff": (
            f"{_HERE}.mem_files:diff",
            Text("compare two dumps (needs no port)", "сравнить два образа (порт не нужен)"),
        ),
        "goto": (
            f"{_HERE}.mem_cells:goto",
            Text("jump to an address: dangerous", "переход по адресу: опасно"),
        ),
    },
    text=Text(
        "The unit's memory: RAM, XRAM, CODE and SFR. Not every unit lets it be read; nobody has "
        "tried these commands on all of them.",
        "Память блока: RAM, XRAM, CODE и SFR. Не каждый блок даёт её читать; на всех блоках эти "
        "команды никто не пробовал.",
    ),
    examples=("mikas mem read ram 40 16", "mikas mem dump code -o code.bin --verify"),
    params=list(common_options()),
)
