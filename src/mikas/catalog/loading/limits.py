"""The alarm limits of an entry, with the checks that concern several keys at once."""

from __future__ import annotations

from pathlib import PurePath
from typing import Any

from mikas.catalog.limits import LIMITS, AlarmLimits
from mikas.catalog.loading.entries import Entry
from mikas.errors import UsageError
from mikas.i18n import Text

_OF_NUMBERS = (*LIMITS, "hysteresis")
_OF_FLAGS = ("when_true",)

NOT_FOR_FLAGS = Text("makes no sense for a flag", "для признака не имеет смысла")
ONLY_FOR_FLAGS = Text("makes sense for a flag only", "имеет смысл только для признака")


def alarm_limits(entry: Entry, *, is_flag: bool) -> AlarmLimits | None:
    """What its table `limits` says; None if no limit is left in it."""
    table = entry.values.get("limits", {})
    unfit, problem = (_OF_NUMBERS, NOT_FOR_FLAGS) if is_flag else (_OF_FLAGS, ONLY_FOR_FLAGS)
    for key in unfit:
        # What an earlier file said, before a later one made a flag of it (or a number), is dropped.
        if key in table and entry.order(("limits", key)) >= entry.order(("mask",)):
            raise entry.wrong(("limits", key), problem)
    values: dict[str, Any] = {"source": PurePath(entry.source.name).name}
    values |= {key: value for key, value in table.items() if key not in unfit}
    try:
        limits = AlarmLimits(**values)
    except UsageError as error:
        written = [("limits", key) for key in reversed(_OF_NUMBERS) if key in table]
        raise entry.wrong(max(written, key=entry.order), _problem(error)) from None
    return limits if limits.for_number or limits.for_flag else None


def _problem(error: UsageError) -> Text:
    return Text(f"can't be: {error.reason.en}", f"не годится: {error.reason.ru}")
