"""`mikas list set`, `mikas list read`: the list in the unit that 63 reads (§3)."""

from __future__ import annotations

from mikas.cli.click_extensions import YES, argument, command
from mikas.cli.commands.unit.parameters import show_readings
from mikas.cli.completion.values import channel_names
from mikas.cli.context import CommandContext
from mikas.cli.language import tr
from mikas.cli.options.common import RELEARN
from mikas.errors import NoList
from mikas.i18n import Text

_SET_OR_NAME = Text(
    "`mikas list set NAME…` sets it; or name its parameters in their order: "
    "`mikas list read NAME…`.",
    "Задать: `mikas list set NAME…`; или назовите его параметры по порядку: "
    "`mikas list read NAME…`.",
)


@command(
    en="Sets the unit's list to each NAME (64): asks first. Changes nothing else in the unit, and "
    "is undone by its next power-off. The names are kept for `mikas list read`.",
    ru="Записывает в блок список из NAME (64): спрашивает подтверждение. Больше в блоке ничего не "
    "меняет, отключение питания отменяет. Имена сохраняются для `mikas list read`.",
    examples=("mikas list set FREQ TWAT INJ", "mikas list set 0x3F:2 --yes --json"),
)
@argument("names", "NAME...", nargs=-1, required=True, shell_complete=channel_names)
@RELEARN
@YES
def set(context: CommandContext, names: tuple[str, ...], *, yes: bool) -> None:  # noqa: A001  (as above)
    shown = " ".join(context.options.catalog.parameter(name).name for name in names)
    confirm = context.confirm(yes=yes, meaning=lambda hexed: f"{shown} ({hexed})")
    with context.ecu(confirm) as ecu:
        listed = ecu.set_list(*names)
    context.output.result(
        {"names": listed},
        tr(f"The unit's list: {shown}", f"Список блока: {shown}"),
    )


@command(
    en="Reads the unit's list once (63), as `mikas list set` has set it last. The unit does not "
    "say which parameters it has: a list set by another program needs each NAME in order.",
    ru="Читает список блока один раз (63), каким его последний раз задала `mikas list set`. Блок "
    "не сообщает, какие в нём параметры: для списка другой программы назовите NAME по порядку.",
    examples=("mikas list read", "mikas list read FREQ TWAT INJ --json"),
)
@argument("names", "[NAME]...", nargs=-1, shell_complete=channel_names)
@RELEARN
def read(context: CommandContext, names: tuple[str, ...]) -> None:
    with context.ecu() as ecu:
        try:
            readings = ecu.read_list(*names)
        except NoList as error:
            error.advice = _SET_OR_NAME
            raise
    show_readings(context, readings)
