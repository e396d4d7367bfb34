"""`mikas raw`: any request."""

from __future__ import annotations

from mikas.cli.click_extensions import SURE, YES, argument, command
from mikas.cli.context import CommandContext, check_sure
from mikas.cli.options.parameter_types import hex_bytes
from mikas.commands import COMMANDS_BY_CODE, Safety
from mikas.i18n import Text


@command(
    en="Sends HEX as a request's body (checksum, stuffing and 0D are added) and prints the "
    "response's body. Asks first, unless the request is known to be harmless. For a jump (41) "
    "and writes to CODE (16, 26) --yes alone is not enough.",
    ru="Отправляет HEX как тело запроса (контрольная сумма, замена байтов и 0D добавляются) и "
    "печатает тело ответа. Если запрос не из безвредных, спрашивает подтверждение. Для "
    "перехода (41) и записи в CODE (16, 26) одного --yes недостаточно.",
    examples=(
        "mikas raw 611A",
        'mikas raw "02" --json',
        "mikas raw 620E08 --yes",
        "mikas raw 410080 --yes --i-know-what-this-does",
    ),
)
@argument("body", "HEX", type=hex_bytes, nargs=1)
@YES
@SURE
def raw(context: CommandContext, body: bytes, *, yes: bool, sure: bool) -> None:
    known = COMMANDS_BY_CODE.get(body[0])
    if known and known.SAFETY is Safety.DANGEROUS:
        sent = body.hex(" ").upper()
        check_sure(Text(f"send {sent}", f"послать {sent}"), yes=yes, sure=sure)
    with context.ecu(context.confirm(yes=yes)) as ecu:
        response = ecu.raw(body)
    if context.output.json:
        context.output.data({"request": body, "response": response})
    elif response is not None:
        context.output.line(response.hex(" ").upper())
    elif known and not known.ANSWERED:
        context.say_sent()
    else:
        context.say(
            "No response: the unit does not know this request, or does not answer it.",
            "Ответа нет: блок не знает этой команды или не отвечает на неё.",
        )
