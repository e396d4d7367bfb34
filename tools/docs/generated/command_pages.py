"""The commands of the protocol as a page, from the tables that decoders have."""

from __future__ import annotations

from typing import Any

from mikas.catalog import Catalog
from mikas.commands import COMMANDS_BY_CODE, Safety
from mikas.dissectors.tables import tables_of
from mikas.i18n import Language, Text
from tools.docs.generated.tables import code, page, table

_SAFETY = {
    Safety.READ: Text("reads", "чтение"),
    Safety.REVERSIBLE: Text("changes, reversible", "меняет, обратимо"),
    Safety.LASTING: Text("changes, may stay", "меняет, может остаться"),
    Safety.DANGEROUS: Text("**dangerous**", "**опасно**"),
}
_PARTS = {
    "address": Text("address", "адрес"),
    "count": Text("N", "N"),
    "bytes": Text("N bytes", "N байт"),
    "value": Text("byte", "байт"),
    "code": Text("code", "код"),
    "datum": Text("datum", "данные"),
    "codes": Text("codes", "коды"),
    "values": Text("data of the codes", "данные по кодам"),
    "model": Text("model", "модель"),
    "faults": Text("N, then number `E0` N times", "N, затем N раз номер `E0`"),
    "text": Text("16 characters", "16 символов"),
    "result": Text("`00` done, `01` refused", "`00` выполнено, `01` отказ"),
    "any": Text("none expected", "ответа не ждут"),
}


def commands(catalog: Catalog, language: Language) -> str:
    """Return the page of the commands."""
    headers = (
        "code|name|what|request|response|effect",
        "код|имя|что делает|запрос|ответ|изменяет",
    )
    rows = (_row(each, language) for each in tables_of(catalog, language)["commands"].values())
    return page("commands", language, commands=table(language, headers, rows))


def _row(command: dict[str, Any], language: Language) -> tuple[str, ...]:
    def body(parts: list[str]) -> str:
        return " · ".join(_PARTS[part].to(language) for part in parts)

    first = code(f"{command['code']:02X}")
    responses = Text(" or ", " или ").to(language).join(map(body, command["responses"]))
    again = Text(", again and again", ", снова и снова").to(language) if command["stream"] else ""
    return (
        first,
        command["name"],
        command["title"],
        " · ".join(filter(None, (first, body(command["request"])))),
        responses + again,
        _SAFETY[COMMANDS_BY_CODE[command["code"]].SAFETY].to(language),
    )
