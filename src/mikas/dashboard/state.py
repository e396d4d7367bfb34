"""The state of everything, as the band at the top of the page shows it: the truth of the line."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, Field

from mikas.client.methods import Method
from mikas.dashboard.api.errors import TwoTexts

Line = Literal["off", "no-port", "no-echo", "echo-only", "ecu-alive", "sampling"]


class WantedOne(BaseModel):
    """A channel, and in which cycles it is asked: 1 is every one, 10 every tenth."""

    name: str = Field(min_length=1, max_length=40, examples=["TWAT"])
    every: int = Field(1, ge=1, le=1000)


class PlanOfState(BaseModel):
    """What is asked."""

    wanted: list[WantedOne]
    method: Method
    rate: float | None = Field(description="sets a second at most; null: as fast as it goes")


class RecordingOfState(BaseModel):
    """The recording that is being made."""

    file: str
    since: float | None
    bytes: int
    samples: int
    gaps: int
    failure: TwoTexts | None = Field(description="why it broke off, if it did")


class AlarmOfState(BaseModel):
    """A channel that is beyond a limit now."""

    name: str
    level: Literal["warning", "danger"]
    side: Literal["low", "high"]
    value: float
    limit: float
    since: float


class Holder(BaseModel):
    """Who decides what the line does."""

    id: str
    name: str
    you: bool


class State(BaseModel):
    """Everything at a glance. Times are UNIX seconds of the link's clock."""

    line: Line
    text: TwoTexts
    reason: TwoTexts | None = Field(description="what is wrong and what to try, while it is")
    reason_code: str | None = Field(description="the same as the class of the error: NoEcho…")
    since: float
    port: str | None
    adapter: str
    model: TwoTexts | None
    version_code: int | None
    passport: list[str | None] | None
    method: str | None = Field(description="in use; plan.method is what was asked for")
    rates: dict[str, float] = Field(description="sets a second of each method that was measured")
    rate: float
    bus_load: float
    errors_minute: int
    errors: int
    samples: int
    plan: PlanOfState
    dropped_parameters: list[str]
    recording: RecordingOfState | None
    alarms: list[AlarmOfState]
    alarm_count: int = Field(description="alarms that began since the connection was made")
    fault_count: int | None = Field(description="when they were last read; null: not yet")
    unlocked_until: float | None
    demo: bool
    lan: bool
    controller: Holder | None = None
    rights: Literal["control", "view"] = "view"
    viewers: int = 0
    now: float = 0.0


OWN = ("controller", "rights", "viewers", "now")
"""What differs from client to client, or from moment to moment."""
