"""Models of the live WebSocket's messages and of events, for the OpenAPI description only.

Messages are built as text up to 20 times a second (`live`), without validation; a test validates
real messages against these models. The models of events are made of the event classes.
"""

from __future__ import annotations

from dataclasses import fields
from typing import Annotated, Any, Final, Literal, Union, get_type_hints

from pydantic import BaseModel, ConfigDict, Field, GetPydanticSchema, create_model
from pydantic.json_schema import JsonSchemaMode, models_json_schema

from mikas.catalog import Level
from mikas.client import Passport
from mikas.dashboard.api.errors import TwoTexts
from mikas.dashboard.api.state import State
from mikas.dashboard.session.history import ActionDone, ExchangeFailed, RecordingChanged
from mikas.i18n import Text
from mikas.sampling import events
from mikas.sampling.alarms import Side
from mikas.sampling.instrument_changes import InstrumentChanged

_MESSAGE: Final = ConfigDict(extra="forbid", allow_inf_nan=False)


_FIELDS: Final[dict[Any, Any]] = {
    Text: TwoTexts | None,
    Text | None: TwoTexts | None,
    Passport | None: list[str | None] | None,
}
"""The JSON of fields, where it is not the type itself."""


def _model(event: type[events.Event], **other: Any) -> type[BaseModel]:
    """Return the model of the event's JSON; `other`: fields that are not as in the class."""
    hints = get_type_hints(event)
    names = [each.name for each in fields(event) if each.metadata.get("json", True)]
    described: dict[str, Any] = {name: _FIELDS.get(hints[name], hints[name]) for name in names}
    return create_model(
        f"{event.kind.title()}Event",
        __config__=ConfigDict(extra="forbid"),
        __doc__=(event.__doc__ or "").partition("\n\n")[0],
        **({"kind": Literal[event.kind]} | described | other),
    )


def _one_of(*models: type[BaseModel]) -> GetPydanticSchema:
    union: Any = Annotated[Union[models], Field(discriminator="kind")]  # noqa: UP007  (of a tuple)
    return GetPydanticSchema(lambda _, handler: handler.generate_schema(union))


def _absent(description: str | None = None) -> Any:  # noqa: ANN401  (as `Field`)
    """Return a field that is absent unless it is set: a factory's default is not described."""
    return Field(default_factory=lambda: None, description=description)


_IN_BOTH: Final = (
    _model(
        events.StateChanged,
        state=events.LineState,
        code=(str | None, Field(None, description="the error's class; not in recordings")),
    ),
    _model(events.Gap),
    _model(events.AdapterMoved),
    _model(events.ClockChanged, text=TwoTexts),
    _model(events.UnitFound, version_code=str | None),
    _model(events.MethodChosen),
    _model(events.ParameterDropped),
    _model(events.ParameterReturned),
    _model(events.AlarmChanged, level=Level, before=Level | None, side=Side | None),
    _model(events.Marker, removed=(bool, _absent("true: the marker was removed; else absent"))),
    _model(events.FaultReading, codes=list[int], added=list[int] | None),
)
LiveEvent = Annotated[
    Any,
    _one_of(
        *_IN_BOTH,
        _model(ExchangeFailed, text=TwoTexts),
        _model(RecordingChanged),
        _model(ActionDone, text=TwoTexts),
        _model(InstrumentChanged, text=TwoTexts),
    ),
]
"""Any event of the running connection."""
RecordedEvent = Annotated[Any, _one_of(*_IN_BOTH, _model(events.TextNote))]
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
    state: State = _absent("in the first, and when it has changed")
    later: float = _absent(
        "with data or events: by how many seconds the date was set since the program began; when "
        "it changes, all times that were sent before are to be moved by the difference"
    )
    data: LiveRows = _absent()
    events: list[LiveEvent] = _absent()
    pong: float | int | str = _absent()


class PingMessage(BaseModel):
    """Answered by `pong` in the next message."""

    model_config = _MESSAGE
    ping: float | int | str


class FieldsMessage(BaseModel):
    """Send only these columns from now on; null: all."""

    model_config = _MESSAGE
    fields: Annotated[list[str], Field(max_length=200)] | None


def component_schemas(*models: type[BaseModel]) -> dict[str, Any]:
    """Return the schemas of `models` and of all they contain, as components of the API."""
    sent: list[tuple[type[BaseModel], JsonSchemaMode]] = [(it, "serialization") for it in models]
    _, schema = models_json_schema(sent, ref_template="#/components/schemas/{model}")
    found: dict[str, Any] = schema["$defs"]
    return found
