"""`mikas raw`: any request body, and the response's body."""

from __future__ import annotations

import click

from mikas.cli.click_extensions import YES, command
from mikas.cli.context import CommandContext
from mikas.cli.language import tr
from mikas.cli.parameter_types import HexBytes
from mikas.i18n import Text


@command(
    "raw",
    Text(
        "Sends HEX as a request's body (checksum, stuffing and 0D are added) and prints the "
        "response's body. Asks first, unless the request is known to be harmless.",
        "Отправляет HEX как тело запроса (контрольная сумма, замена байтов и 0D добавляются) и "
        "печатает тело ответа. Если запрос не из безвредных, спрашивает подтверждение.",
    ),
    examples=("mikas raw 611A", 'mikas raw "02" --json', "mikas raw 620E08 --yes"),
)
@click.argument("body", metavar="HEX", type=HexBytes(), nargs=1)
@YES
def raw(context: CommandContext, body: bytes, *, yes: bool) -> None:
    with context.ecu(context.confirm(yes=yes)) as ecu:
        response = ecu.raw(body)
    if context.output.json:
        context.output.data({"request": body, "response": response})
    elif response is None:
        context.output.note(
            tr(
                "No response: the unit does not know this request, or does not answer it.",
                "Ответа нет: блок не знает этой команды или не отвечает на неё.",
            )
        )
    else:
        context.output.line(response.hex(" ").upper())
