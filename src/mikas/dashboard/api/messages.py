"""Models of the live WebSocket's messages and of events. They describe; nothing is validated here.

Messages are built as text up to 20 times a second (`broadcaster`), so no model stands in that path;
a test validates real messages against these models. The OpenAPI description has them as components.
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
_EVENT: Final = ConfigDict(extra="forbid")


class StateEvent(BaseModel):
    """The line changed to `state`. `code`: the class of the error that caused it."""

    model_config = _EVENT
    kind: Literal["state"]
    time: float
    state: LineState
    text: TwoTexts | None
    reason: TwoTexts | None
    code: Annotated[str | None, Field(description="not in recordings")] = None


class GapEvent(BaseModel):
    """No values came. Sent when the gap begins (`ended` null) and once more when it has ended."""

    model_config = _EVENT
    kind: Literal["gap"]
    time: float
    began: float
    ended: float | None
    reason: TwoTexts | None


class ErrorEvent(BaseModel):
    """An exchange failed, also one that a repetition cured. `sent`, `received`: hex."""

    model_config = _EVENT
    kind: Literal["error"]
    time: float
    code: str
    text: TwoTexts
    sent: str | None
    received: str | None


class UnitEvent(BaseModel):
    """A unit answers. `another`: not the one before, on this connection or the last."""

    model_config = _EVENT
    kind: Literal["unit"]
    time: float
    model: TwoTexts | None
    version_code: int | None
    passport: list[str | None] | None
    another: bool


class MethodEvent(BaseModel):
    """The sampling method was chosen. `rates`: readings a second of each measured method."""

    model_config = _EVENT
    kind: Literal["method"]
    time: float
    method: str
    rates: dict[str, float]


class DroppedEvent(BaseModel):
    """The unit does not support this parameter."""

    model_config = _EVENT
    kind: Literal["dropped"]
    time: float
    name: str


class AlarmEvent(BaseModel):
    """A value crossed a limit, in either direction. `level` none: the alarm is over."""

    model_config = _EVENT
    kind: Literal["alarm"]
    time: float
    name: str
    level: Level
    before: Level | None
    side: Side | None
    value: float | None
    limit: float | None
    text: TwoTexts | None


class MarkerEvent(BaseModel):
    """Somebody marked this moment."""

    model_config = _EVENT
    kind: Literal["marker"]
    time: float
    label: str


class RecordingEvent(BaseModel):
    """A recording began, ended or broke off (`failure`)."""

    model_config = _EVENT
    kind: Literal["recording"]
    time: float
    file: str
    on: bool
    failure: TwoTexts | None


class NoteEvent(BaseModel):
    """A note that somebody wrote; in recordings only."""

    model_config = _EVENT
    kind: Literal["note"]
    time: float
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
    """Columns over time. null: no value came in that row."""

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
    """Send only these columns from here on; null: all."""

    model_config = _MESSAGE
    fields: list[str] | None


def component_schemas(*models: type[BaseModel]) -> dict[str, Any]:
    """Return the schemas of `models` and of all they contain, as components of the API."""
    sent: list[tuple[type[BaseModel], JsonSchemaMode]] = [(it, "serialization") for it in models]
    _, schema = models_json_schema(sent, ref_template="#/components/schemas/{model}")
    found: dict[str, Any] = schema["$defs"]
    return found
