"""Arguments of the command line that are neither words nor plain numbers."""

from __future__ import annotations

import click

from mikas.cli.words import say


class HexBytes(click.ParamType[bytes]):
    """Bytes in hex: `61 1A`, `611A`, `61:1a`, `0x611A`."""

    name = "hex"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> bytes:
        if isinstance(value, bytes):
            return value
        text = str(value)
        plain = text.lower().removeprefix("0x").replace(" ", "").replace(":", "")
        try:
            data = bytes.fromhex(plain)
        except ValueError:
            data = b""
        if not data:
            self.fail(
                say(
                    f"“{text}” is not bytes in hex; write them like 611A, two digits a byte",
                    f"«{text}» — не байты в шестнадцатеричном виде; пишите так: 611A, по две цифры",
                ),
                param,
                ctx,
            )
        return data


class Address(click.ParamType[int]):
    """An address: hex, with or without 0x; `0d64` or `64d` for a decimal one."""

    name = "address"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> int:
        if isinstance(value, int):
            return value
        text = str(value).strip()
        try:
            return int(text.lower().removeprefix("0x").removesuffix("h"), 16)
        except ValueError:
            self.fail(
                say(
                    f"“{text}” is not an address; write it in hex, like 8000 or 0x8000",
                    f"«{text}» — не адрес; пишите его в шестнадцатеричном виде: 8000 или 0x8000",
                ),
                param,
                ctx,
            )


class Count(click.ParamType[int]):
    """A number of bytes: decimal, or hex with 0x."""

    name = "count"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> int:
        if isinstance(value, int):
            return value
        try:
            count = int(str(value), 0)
        except ValueError:
            count = 0
        if count < 1:
            self.fail(
                say(
                    f"“{value}” is not a number of bytes; write 16, or 0x10",
                    f"«{value}» — не число байтов; пишите 16 или 0x10",
                ),
                param,
                ctx,
            )
        return count
