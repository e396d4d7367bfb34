"""Instruments and their definitions as JSON."""

from __future__ import annotations

from typing import Annotated, Any, Final, Literal

from pydantic import BaseModel, Field

from mikas.catalog import Confidence
from mikas.cleaning import public_port
from mikas.dashboard.api.channel_info import ChannelInfo, instrument_channel_info
from mikas.dashboard.api.dependencies import Line
from mikas.dashboard.api.errors import TwoTexts, made_of, two
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.security.control import Client
from mikas.dashboard.session.instruments.positions import PHONE, POSITIONS, phone
from mikas.i18n import Text
from mikas.instruments import InstrumentDefinition, definition_named, definition_names
from mikas.instruments.choosing import ChosenInstrument
from mikas.instruments.reading import InstrumentReader, InstrumentState

NowState = Literal["off", "connecting", "connected", "values", "stale", "silent", "lost"]
Finite = Annotated[float, Field(allow_inf_nan=False)]

_TEXTS: Final[dict[NowState, Text]] = {
    "off": Text("It is read once the unit's port is open.", "Читается, когда открыт порт блока."),
    "connecting": Text("The port is being opened.", "Порт открывается."),
    "connected": Text("Connected; no value yet.", "Подключён; значений ещё нет."),
    "values": Text("Values come.", "Значения идут."),
    "stale": Text("The last value is too old.", "Последнее значение устарело."),
    "silent": Text(
        "No values ({why}); check its wire and its speed (baud).",
        "Значений нет ({why}); проверьте провод и скорость порта.",
    ),
    "lost": Text(
        "Not there ({why}); it is tried again, and the unit is read on.",
        "Не отвечает ({why}); попытки продолжаются, опрос блока идёт дальше.",
    ),
}
_UNKNOWN: Final = Text("the reason is not known", "причина неизвестна")


class InstrumentNow(BaseModel):
    """The state of an instrument."""

    name: str = Field(description="with its label: `left:aem`", examples=["aem"])
    state: NowState
    text: TwoTexts = Field(description="the state in words")
    damaged: int = Field(description="messages that gave no value, since it is read")


class InstrumentStates(BaseModel):
    """The states of all instruments."""

    instruments: list[InstrumentNow]


class InstrumentInfo(InstrumentNow):
    """An instrument that the user has chosen."""

    definition: str
    label: str
    port: str = Field(description="without a password")
    title: TwoTexts
    channels: list[str]


class InstrumentDefinitionInfo(BaseModel):
    """A definition. `own`: the user's, which may be changed and deleted here."""

    name: str
    text: TwoTexts
    decoder: str
    baud: int
    stale: float
    patterns: list[str]
    decimal: str
    channels: list[ChannelInfo]
    confidence: Confidence
    own: bool
    at: Literal["port", "gpsd", "position"] = Field(description="where it is read")


class InstrumentsResponse(BaseModel):
    """The instruments, the definitions, and all their channels."""

    instruments: list[InstrumentInfo]
    channels: list[ChannelInfo] = Field(description="of the instruments")
    known: list[ChannelInfo] = Field(description="of the catalog; a recording may have them")
    definitions: list[InstrumentDefinitionInfo]
    problems: list[TwoTexts] = Field(
        description="kept instruments and files that can't be used; empty without control rights"
    )
    network: bool = Field(description="gpsd and ports of a network can be reached")


class NewInstrument(BaseModel):
    """An instrument to read. `port`: as of a unit, `gpsd:HOST:PORT`, `sim:` or `position:`."""

    definition: Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9-]{0,39}$", examples=["aem"])]
    port: Annotated[Line, Field(min_length=1, max_length=500, examples=["/dev/ttyUSB1"])]
    label: Annotated[str, Field(pattern=r"^([A-Za-z][A-Za-z0-9_]{1,19})?$")] = ""


class NewTexts(BaseModel):
    """A text in both languages."""

    en: Annotated[Line, Field(min_length=1, max_length=200)]
    ru: Annotated[Line, Field(min_length=1, max_length=200)]


class OwnChannel(BaseModel):
    """A channel that the catalog lacks."""

    name: Annotated[str, Field(pattern=r"^[A-Z][A-Z0-9_]{0,19}$", examples=["BOOST_BAR"])]
    text: NewTexts
    unit: Annotated[Line, Field(max_length=40)] = ""
    decimals: Annotated[int, Field(ge=0, le=6)] | None = Field(
        None, description="null: as it is, or two"
    )
    range: tuple[Finite, Finite] | None = None


class OwnDefinition(BaseModel):
    """A definition of lines of text. In a pattern `{NAME}` is a value (docs/how-to/instruments.md).

    `channels`: those of the patterns that the catalog lacks.
    """

    text: NewTexts
    baud: Annotated[int, Field(ge=50, le=4_000_000)] = 9600
    patterns: Annotated[
        list[Annotated[Line, Field(min_length=1, max_length=200)]],
        Field(min_length=1, max_length=20),
    ]
    decimal: Literal[".", ","] = "."
    stale: Annotated[float, Field(gt=0, le=3600, allow_inf_nan=False)] = 1.0
    channels: Annotated[list[OwnChannel], Field(max_length=20)] = []

    def keys(self) -> dict[str, Any]:
        """Return the keys of the file."""
        own = {}
        for channel in self.channels:
            keys = channel.model_dump(exclude={"name"}, exclude_none=True)
            if not channel.unit:
                del keys["unit"]
            if channel.range:
                keys["range"] = list(channel.range)
            own[channel.name] = keys
        keys = self.model_dump(exclude={"channels"})
        return {**keys, "instrument": own} if own else keys


class Position(BaseModel):
    """A position as a browser gives it; null: not known."""

    latitude: Annotated[Finite, Field(ge=-90, le=90)]
    longitude: Annotated[Finite, Field(ge=-180, le=180)]
    altitude: Finite | None = None
    speed: Annotated[Finite, Field(ge=0)] | None = Field(None, description="metres a second")
    heading: Annotated[Finite, Field(ge=0, le=360)] | None = None

    def report(self) -> dict[str, float]:
        """Return the keys of gpsd's TPV."""
        keys = {
            "lat": self.latitude, "lon": self.longitude, "alt": self.altitude,
            "speed": self.speed, "track": self.heading,
        }  # fmt: skip
        return {key: value for key, value in keys.items() if value is not None}


def instruments_now(dashboard: Dashboard) -> list[InstrumentNow]:
    """Return the states of all instruments."""
    readers, fresh = dashboard.instruments.readers(), dashboard.instruments.fresh()
    return [_now(each, readers.get(each.title), fresh) for each in dashboard.instruments.chosen]


def _now(
    chosen: ChosenInstrument, reader: InstrumentReader | None, fresh: dict[str, Any]
) -> InstrumentNow:
    state: NowState = "off" if reader is None else "connecting"
    why = _UNKNOWN
    if reader is not None and (latest := reader.latest) is not None:
        state, why = latest.state.value, latest.reason or _UNKNOWN
        if latest.state is InstrumentState.VALUES:
            state = "values" if any(it.name in fresh for it in chosen.channels) else "stale"
    return InstrumentNow(
        name=chosen.title,
        state=state,
        text=two(_TEXTS[state].filled(why=why)),
        damaged=reader.damaged if reader else 0,
    )


def instruments_of(dashboard: Dashboard, client: Client) -> InstrumentsResponse:
    """Return everything, as `client` sees it; reads the user's files."""
    beside, catalog = dashboard.instruments, dashboard.catalog
    own, problems = beside.own.all(catalog)
    entries = dashboard.catalogs.own.entries()
    shipped = {name: definition_named(name, catalog) for name in definition_names()}
    definitions = {PHONE: phone(catalog)} | shipped | own
    chosen = {each.title: each for each in beside.chosen}
    now = [it for it in instruments_now(dashboard) if it.name in chosen]
    return InstrumentsResponse(
        instruments=[_info(chosen[it.name], it) for it in now],
        channels=[instrument_channel_info(channel, entries) for channel in beside.channels],
        known=[instrument_channel_info(it, entries) for it in catalog.instruments.values()],
        definitions=[_definition(it, own=name in own) for name, it in definitions.items()],
        problems=[two(problem) for problem in (*beside.problems, *problems)]
        if client.may_control
        else [],
        network=dashboard.settings.sockets,
    )


def _info(chosen: ChosenInstrument, now: InstrumentNow) -> InstrumentInfo:
    return InstrumentInfo(
        **now.model_dump(),
        definition=chosen.definition.name,
        label=chosen.label,
        port=public_port(chosen.url),
        title=two(chosen.definition.text),
        channels=[channel.name for channel in chosen.channels],
    )


def _definition(definition: InstrumentDefinition, *, own: bool) -> InstrumentDefinitionInfo:
    at = "port"
    if definition.name == PHONE:
        at = POSITIONS.removesuffix(":")
    elif definition.decoder == "gpsd":
        at = "gpsd"
    return made_of(
        InstrumentDefinitionInfo,
        definition,
        channels=[instrument_channel_info(channel, {}) for channel in definition.channels],
        own=own,
        at=at,
    )
