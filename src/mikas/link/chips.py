"""The USB serial chips of adapters, and the quirks of each: the one table of them.

A K-Line adapter is a level shifter on such a chip, and looks like any other device with it.
"""

from __future__ import annotations

from typing import Final

from mikas.i18n import Text

LATENCY = Text(
    "hands over received bytes after up to 16 ms (its latency timer); that is lowered to 1 ms "
    "where the system lets a program do it, on Windows by hand: Device Manager, the port, "
    "Port Settings, Advanced",
    "отдаёт принятое с задержкой до 16 мс (latency timer); где система даёт, программа сама ставит "
    "1 мс, в Windows это делают вручную: Диспетчер устройств, порт, Параметры порта, Дополнительно",
)
_LUMPS = Text(
    "with an old driver it hands over received bytes in lumps of 32, with a new one at once; it "
    "does not report bytes that were damaged on the line",
    "со старым драйвером отдаёт принятое порциями по 32 байта, с новым — сразу; о байтах, "
    "испорченных на линии, не сообщает",
)
_USUAL_RATES = Text(
    "a CP2101, CP2102, CP2103 or CP2108 knows the usual baud rates only: 9600 is exact, 10400 "
    "becomes 14400",
    "CP2101, CP2102, CP2103 и CP2108 знают только обычные скорости: 9600 точная, вместо 10400 "
    "выходит 14400",
)
_CLONES = Text(
    "cheap cables with it vary: some have a weak K-Line driver or no echo",
    "дешёвые кабели с ней разные: бывает слабый драйвер K-Line, бывает нет эха",
)
_COUNTERFEIT = Text(
    "many are counterfeit, and the maker's newer Windows drivers refuse those (code 10, or “phased "
    "out”); Linux gives no port to a copy of a version that it does not know: install an older "
    "driver or take another cable",
    "много подделок, а новые драйверы изготовителя для Windows их не пускают (код 10 или «phased "
    "out»); Linux не даёт порта подделке незнакомой версии: поставьте старый драйвер или возьмите "
    "другой кабель",
)
_UNKNOWN = Text(
    "an unknown USB device: possibly an adapter; the connection check shows whether it works",
    "неизвестное устройство USB: возможно, адаптер; работает ли он, покажет проверка связи",
)

OF_DRIVERS: Final = (LATENCY, _LUMPS, _COUNTERFEIT)
"""The quirks of systems' drivers, which a page that drives the chip itself does not have."""

_FTDI, _CH340, _PROLIFIC = (LATENCY,), (_LUMPS, _CLONES), (_COUNTERFEIT,)
_CP210X = (_USUAL_RATES,)

CHIPS: Final[dict[tuple[int, int], tuple[str, tuple[Text, ...]]]] = {
    (0x0403, 0x6001): ("FT232R", _FTDI),
    (0x0403, 0x6015): ("FT231X", _FTDI),
    (0x0403, 0x6014): ("FT232H", _FTDI),
    (0x0403, 0x6010): ("FT2232", _FTDI),
    (0x0403, 0x6011): ("FT4232", _FTDI),
    (0x0403, 0): ("FTDI", _FTDI),
    (0x1A86, 0x7523): ("CH340", _CH340),
    (0x1A86, 0x7522): ("CH340", _CH340),
    (0x1A86, 0x5523): ("CH341", _CH340),
    (0x4348, 0x5523): ("CH341", _CH340),
    (0x1A86, 0x55D2): ("CH342", ()),
    (0x1A86, 0x55D3): ("CH343", ()),
    (0x1A86, 0x55D4): ("CH9102", ()),
    (0x10C4, 0xEA60): ("CP210x", _CP210X),
    (0x10C4, 0xEA70): ("CP2105", ()),
    (0x10C4, 0xEA71): ("CP2108", _CP210X),
    (0x067B, 0x2303): ("PL2303", _PROLIFIC),
    (0x067B, 0x23A3): ("PL2303GC", ()),
    (0x067B, 0x23B3): ("PL2303GB", ()),
    (0x067B, 0x23C3): ("PL2303GT", ()),
    (0x067B, 0x23D3): ("PL2303GL", ()),
    (0x067B, 0): ("PL2303", _PROLIFIC),
    (0x04D8, 0x00DD): ("MCP2221", ()),
    (0x04D8, 0x00DF): ("MCP2200", ()),
    (0x04E2, 0x1410): ("XR21V1410", ()),
}
"""The name and the quirks by USB vendor and product; product 0: any other one of the vendor.

The most frequent chips of K-Line cables come first: FT232R, then CH340.
"""


def chip_of(vid: int | None, pid: int | None) -> tuple[str, tuple[Text, ...]]:
    """Return the name and the quirks of a device's chip; an unknown chip has no name."""
    if vid is None:
        return "", ()
    return CHIPS.get((vid, pid or 0)) or CHIPS.get((vid, 0)) or ("", (_UNKNOWN,))


def has_latency_timer(chip: str) -> bool:
    """Return whether the chip of this name has a latency timer: FTDI's have."""
    return any(name == chip and LATENCY in quirks for name, quirks in CHIPS.values())


def has_usual_rates(chip: str) -> bool:
    """Return whether the chip of this name may know the usual baud rates only."""
    return any(name == chip and _USUAL_RATES in quirks for name, quirks in CHIPS.values())


def known_products() -> dict[tuple[int, int], str]:
    """Return the names by vendor and product, without those for any other product."""
    return {ids: name for ids, (name, _) in CHIPS.items() if ids[1]}
