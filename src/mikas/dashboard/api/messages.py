"""Models of the live WebSocket's messages and of events, for the OpenAPI description only.

Messages are built as text up to 20 times a second (`live`), without validation; a test validates
real messages against these models.
"""

from __future__ import annotations

from typing import Annotated, Any, Final, Literal

from pydantic import BaseModel, ConfigDict, Field
from pydantic.json_schema import JsonSchemaMode, models_json_schema

from mikas.catalog import Level
from mikas.dashboard.api.errors import TwoTexts
from mikas.dashboard.api.state import State
from mikas.sampling.alarms import Side
from mikas.sampling.events import LineState


def _optional(schema: dict[str, Any]) -> None:
    """Describe a field with a default as absent or set: never null, and with no default."""
    for each in schema["properties"].values():
        if "default" in each and each.pop("default") is None and "anyOf" in each:
            kinds = [kind for kind in each["anyOf"] if kind != {"type": "null"}]
            each.update(kinds[0]) if len(kinds) == 1 else each.update(anyOf=kinds)
            if len(kinds) == 1:
                del each["anyOf"]


_MESSAGE: Final = ConfigDict(extra="forbid", json_schema_extra=_optional)


class _Event(BaseModel):
    model_config = ConfigDict(extra="forbid")
    time: float


class StateEvent(_Event):
    """The line changed to `state`. `code`: the class of the error that caused it."""

    kind: Literal["state"]
    state: LineState
    text: TwoTexts | None
    reason: TwoTexts | None
    code: Annotated[str | None, Field(description="not in recordings")] = None


class GapEvent(_Event):
    """No values were received. Sent when the gap begins (`ended` null) and when it has ended."""

    kind: Literal["gap"]
    began: float
    ended: float | None
    reason: TwoTexts | None


class ErrorEvent(_Event):
    """An exchange failed, also one that a repetition cured. `sent`, `received`: hex."""

    kind: Literal["error"]
    code: str
    text: TwoTexts
    sent: str | None
    received: str | None


class UnitEvent(_Event):
    """A unit answers. `another`: not the one before, on this connection or the last."""

    kind: Literal["unit"]
    model: TwoTexts | None
    version_code: int | None
    passport: list[str | None] | None
    another: bool


class MethodEvent(_Event):
    """The sampling method was chosen. `rates`: readings a second of each measured method."""

    kind: Literal["method"]
    method: str
    rates: dict[str, float]


class DroppedEvent(_Event):
    """The unit does not support this parameter."""

    kind: Literal["dropped"]
    name: str


class AlarmEvent(_Event):
    """A value crossed a limit, in either direction. `level` none: the alarm is over."""

    kind: Literal["alarm"]
    name: str
    level: Level
    before: Level | None
    side: Side | None
    value: float | None
    limit: float | None
    text: TwoTexts | None


class MarkerEvent(_Event):
    """A person marked this moment."""

    kind: Literal["marker"]
    label: str


class RecordingEvent(_Event):
    """A recording began, ended or broke off (`failure`)."""

    kind: Literal["recording"]
    file: str
    on: bool
    failure: TwoTexts | None


class NoteEvent(_Event):
    """A person's note; in recordings only."""

    kind: Literal["note"]
    text: str


LiveEvent = Annotated[
    StateEvent
    | GapEvent
    | ErrorEvent
    | UnitEvent
    | MethodEvent
    | DroppedEvent
    | AlarmEvent
    | MarkerEvent
    | RecordingEvent,
    Field(discriminator="kind"),
]
"""Any event of the running connection."""
RecordedEvent = Annotated[
    StateEvent
    | GapEvent
    | UnitEvent
    | MethodEvent
    | DroppedEvent
    | AlarmEvent
    | MarkerEvent
    | NoteEvent,
    Field(discriminator="kind"),
]
"""Any event of a recording."""


class LiveRows(BaseModel):
    """Columns over time. null: no value in that row."""

    model_config = _MESSAGE
    names: list[str]
    times: list[float]
    values: list[list[float | None]]


class LiveMessage(BaseModel):
    """One message of the server. `dropped`: messages lost before this one."""

    model_config = _MESSAGE
    seq: int
    now: float
    dropped: int
    state: State | None = Field(None, description="in the first, and when it has changed")
    data: LiveRows | None = None
    events: list[LiveEvent] | None = None
    pong: float | int | str | None = None


class PingMessage(BaseModel):
    """Answered by `pong` in the next message."""

    model_config = _MESSAGE
    ping: float | int | str


class FieldsMessage(BaseModel):
    """Send only these columns from now on; null: all."""

    model_config = _MESSAGE
    fields: list[str] | None


def component_schemas(*models: type[BaseModel]) -> dict[str, Any]:
    """Return the schemas of `models` and of all they contain, as components of the API."""
    sent: list[tuple[type[BaseModel], JsonSchemaMode]] = [(it, "serialization") for it in models]
    _, schema = models_json_schema(sent, ref_template="#/components/schemas/{model}")
    found: dict[str, Any] = schema["$defs"]
    return found
