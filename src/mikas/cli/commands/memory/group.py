"""`mikas mem`: the memory commands, one module for those on the unit, one for those on files."""

from __future__ import annotations

from mikas.cli.click_extensions import LocalizedGroup, common_options
from mikas.cli.commands import MEMORY_COMMANDS
from mikas.i18n import Text

mem = LocalizedGroup(
    "mem",
    homes=MEMORY_COMMANDS,
    text=Text(
        "The unit's memory: RAM, XRAM, CODE and SFR. Not every unit lets it be read; nobody has "
        "tried these commands on all of them.",
        "Память блока: RAM, XRAM, CODE и SFR. Не каждый блок даёт её читать; на всех блоках эти "
        "команды никто не пробовал.",
    ),
    examples=("mikas mem read ram 40 16", "mikas mem dump code -o code.bin --verify"),
    params=list(common_options()),
)
