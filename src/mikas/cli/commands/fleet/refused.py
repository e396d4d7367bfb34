"""What of a dataset is left out, and why, as it is said before an answer."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import islice
from typing import TYPE_CHECKING, Final

from mikas.cli.context import CommandContext
from mikas.cli.language import localized
from mikas.cli.render.terminal import cell_text

if TYPE_CHECKING:
    from mikas.i18n import Text

_MOST: Final = 20


def say_refused(context: CommandContext, refused: Mapping[str, Text]) -> None:
    """Name the entries of the ledger that do not count."""
    for name, reason in islice(refused.items(), _MOST):
        context.output.print_note(cell_text(f"{name}: {localized(reason)}"))
    if refused:
        context.say(
            f"Left out of the dataset: {len(refused)} recording(s), named above"
            + ("." if len(refused) <= _MOST else f" (the first {_MOST})."),
            f"Не учтено записей набора: {len(refused)}, они названы выше"
            + ("." if len(refused) <= _MOST else f" (первые {_MOST})."),
        )
