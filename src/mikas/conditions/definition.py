"""A rule of actions: its condition, how long and how often, and its effects.

[action.hot]
when = "TWAT > 105"       a formula of the catalog's language
for = 3                   s that it has to hold, without a pause
until = "TWAT < 100"      before this held, it is not done again; else: `when` does not hold
again = 60                s after which it is done again at the earliest; 1 s without it
once = true               once in a session
mark = "hot: {TWAT}"      the other keys: its effects
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Annotated, Final

from mikas.catalog.formula_syntax import Parsed
from mikas.catalog.loading.fields import TEXT, between, boolean, choice, string
from mikas.i18n import Text

MOST_RULES: Final = 50
LONGEST_HOLD: Final = 3600.0  # s
LONGEST_PAUSE: Final = 86400.0  # s
LEAST_PAUSE: Final = 1.0  # s from one action of a rule to the next, whatever `again` says
LONGEST_WORDS: Final = 200  # characters of a marker, of what is said


class RecordAction(StrEnum):
    """What a rule does with the recording."""

    START = "start"
    STOP = "stop"


@dataclass(frozen=True, slots=True)
class ActionRule:
    """A rule. Fields with a reader are keys of its table; None and an empty text: not there.

    `mark` and `speak` may name the condition's channels in braces: `{TWAT}`.
    """

    name: str
    """The name of its table, which is shown."""
    condition: Parsed
    """The formula `when`."""
    when: Annotated[str, string] = ""
    """The formula, as it was written."""
    hold: Annotated[float, between(0, LONGEST_HOLD), "for"] = 0.0
    """Seconds for which it has to hold."""
    until: Annotated[str, string] = ""
    """The formula that lets the rule act again; empty: the condition no longer holds."""
    release: Parsed | None = field(default=None)
    """That formula, parsed."""
    again: Annotated[float, between(0, LONGEST_PAUSE)] = 0.0
    """Seconds from one action to the next, at least; never less than `LEAST_PAUSE`."""
    once: Annotated[bool, boolean] = False
    """Whether it acts once in a session."""
    mark: Annotated[Text | None, TEXT] = None
    """The name of a marker."""
    record: Annotated[RecordAction | None, choice(RecordAction, *RecordAction)] = None
    """Whether a recording is started or stopped."""
    sound: Annotated[bool, boolean] = False
    """Whether a sound is made: in a terminal its bell."""
    speak: Annotated[Text | None, TEXT] = None
    """What the browser's voice says."""
    mqtt: Annotated[bool, boolean] = False
    """Whether a message is published, by the file's `[mqtt]`."""
    webhook: Annotated[str, string] = ""
    """The address on this computer to which a POST is sent."""

    @property
    def channels(self) -> tuple[str, ...]:
        """The channels of its formulas."""
        more = self.release.inputs if self.release else ()
        return tuple(dict.fromkeys((*self.condition.inputs, *more)))

    @property
    def acts(self) -> bool:
        """Whether it does anything."""
        return bool(
            self.mark or self.record or self.sound or self.speak or self.mqtt or self.webhook
        )
