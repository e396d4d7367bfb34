"""`mikas mem`: commands on the unit's memory."""

from __future__ import annotations

from mikas.cli.click_extensions import LocalizedGroup
from mikas.cli.commands import MEMORY_COMMANDS

mem = LocalizedGroup(
    "mem",
    homes=MEMORY_COMMANDS,
    en="The unit's memory: RAM, XRAM, CODE and SFR. Not every unit allows reading; these commands "
    "have not been tried on all units.",
    ru="Память блока: RAM, XRAM, CODE и SFR. Читать её разрешает не каждый блок; на всех блоках "
    "эти команды не проверялись.",
    examples=("mikas mem read ram 40 16", "mikas mem dump code -o code.bin --verify"),
)
