"""A rule of actions as JSON, and as the table of `actions.toml` that it stands for."""

from __future__ import annotations

from decimal import Decimal
from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field

from mikas.catalog.formula_syntax import LONGEST
from mikas.conditions import ActionRule, LoadedActions
from mikas.conditions.definition import LONGEST_HOLD, LONGEST_PAUSE, LONGEST_WORDS, MOST_RULES
from mikas.dashboard.api.dependencies import Line
from mikas.dashboard.api.errors import OptionalTexts, TwoTexts

Formula = Annotated[Line, Field(max_length=LONGEST)]
Words = Annotated[Line, Field(max_length=LONGEST_WORDS)]


class ActionTexts(BaseModel):
    """A text in both languages; one that is empty is taken from the other."""

    en: Words = ""
    ru: Words = ""


class ActionModel(BaseModel):
    """A rule, as docs/reference/actions.md describes it; empty, null and false: not there."""

    name: Annotated[str, Field(pattern=r"^[\w-]{1,40}$")]
    when: Formula
    hold: float = Field(0, ge=0, le=LONGEST_HOLD, allow_inf_nan=False, description="`for`, in s")
    until: Formula = ""
    again: float = Field(0, ge=0, le=LONGEST_PAUSE, allow_inf_nan=False, description="s")
    once: bool = False
    mark: ActionTexts | None = None
    record: Literal["start", "stop"] | None = None
    sound: bool = False
    speak: ActionTexts | None = None
    mqtt: bool = False
    webhook: Annotated[Line, Field(max_length=500)] = ""

    def table(self) -> dict[str, Any]:
        """Return the table of the rule in the file."""
        table: dict[str, Any] = {
            "when": self.when,
            "for": Decimal(str(self.hold)),
            "until": self.until,
            "again": Decimal(str(self.again)),
            "once": self.once,
            "sound": self.sound,
            "mqtt": self.mqtt,
            "webhook": self.webhook,
        }
        for key, text in (("mark", self.mark), ("speak", self.speak)):
            if text is not None and (text.en or text.ru):
                table[key] = text.model_dump()
        return table | ({"record": self.record} if self.record else {})


class ActionsRequest(BaseModel):
    """All rules, and the broker of those with `mqtt`."""

    rules: list[ActionModel] = Field(max_length=MOST_RULES)
    broker: Annotated[Line, Field(max_length=500)] = ""
    topic: Annotated[Line, Field(max_length=200)] = ""

    def tables(self) -> dict[str, Any]:
        """Return the tables of the file."""
        return {
            "action": {rule.name: rule.table() for rule in self.rules},
            "mqtt": {"broker": self.broker, "topic": self.topic},
        }


class ActionsResponse(ActionsRequest):
    """`problem`: why the file is not used; `network`: whether MQTT and webhooks can be reached."""

    problem: OptionalTexts
    waits: dict[str, TwoTexts] = Field(
        description="why a rule can't act now, by its name: nothing gives a channel of its formulas"
    )
    network: bool
    file: str = Field(description="where the rules are kept")


class ActionTrial(BaseModel):
    """What a rule would have done in the last minutes.

    `value`: what the formula gives now; null: no value, or `problem`. `waits`: as of the rules.
    """

    problem: OptionalTexts
    waits: OptionalTexts
    value: float | None
    times: list[float] = Field(description="at which it would have acted, the first hundred")
    count: int
    seconds: float = Field(description="of data that were looked at")


def model_of(rule: ActionRule) -> ActionModel:
    """Return a rule as JSON."""

    def texts(name: str) -> TwoTexts | None:
        text = getattr(rule, name)
        return TwoTexts(en=text.en, ru=text.ru) if text else None

    return ActionModel.model_validate(
        {
            "name": rule.name, "when": rule.when, "hold": rule.hold, "until": rule.until,
            "again": rule.again, "once": rule.once, "sound": rule.sound, "mqtt": rule.mqtt,
            "webhook": rule.webhook, "record": rule.record and rule.record.value,
            "mark": texts("mark"), "speak": texts("speak"),
        },
        from_attributes=True,
    )  # fmt: skip


def reaches_network(actions: ActionsRequest | LoadedActions) -> tuple[object, ...]:
    """Return what of the rules leads out of this program; only a client on this computer may
    change it.
    """
    rules = sorted((rule.name, rule.webhook, rule.mqtt) for rule in actions.rules)
    return actions.broker, actions.topic, *(it for it in rules if it[1] or it[2])
