"""The changes of the own catalog that a person makes on a screen, as keys of its entries.

    set_keys(own, "TWAT", {"limits": {"danger_high": 115, …}, "gauge": (0, 130)})
    reset_keys(own, "TWAT", ["limits"])          as shipped again
    set_channel(own, "LOAD", {"formula": "100 * JAIR / full", …}, new=True)
    remove_channel(own, "LOAD")

Only what differs from the shipped entry is written. A value that the file can't bring about, as a
file of `--catalog` overrides it, is refused.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, Final

from mikas.catalog.formula_syntax import parse
from mikas.catalog.instrument_channels import InstrumentChannel
from mikas.catalog.limits import LIMITS, AlarmLimits, Level
from mikas.catalog.loading.fields import mnemonic
from mikas.catalog.loading.loader import shipped
from mikas.catalog.lookup import Catalog
from mikas.catalog.model import Derived, Parameter
from mikas.catalog.own.editing import with_keys, without
from mikas.catalog.own.file import OwnCatalog
from mikas.errors import FormulaError, UnknownParameter, UsageError, usage_error
from mikas.i18n import Text

AnyChannel = Parameter | Derived | InstrumentChannel

KEYS: Final = ("limits", "gauge", "reference", "span_least")
"""The keys of any entry that a person changes on a screen."""

_LIMITS: Final = (*LIMITS, "hysteresis", "when_true")
_OVERRIDDEN: Final = Text(
    "a file given with --catalog (or `catalog` in the config file) sets this too, and overrides "
    "your own catalog; change it there",
    "это задаёт и файл из --catalog (или `catalog` в файле настроек), он важнее вашего каталога; "
    "измените значение в нём",
)


def set_keys(own: OwnCatalog, known: Catalog, name: str, keys: Mapping[str, Any]) -> Catalog:
    """Set `KEYS` of a channel of `known`, and return the catalog then.

    None resets a key. `limits` has `danger_low` … `danger_high`, `hysteresis` and `when_true`;
    there None means no such limit. Raises `UnknownParameter`, and as `OwnCatalog.change`.
    """
    channel = _named(known, name)
    origin = shipped()
    shipped_one = origin.channels.get(channel.name) or origin.instruments.get(channel.name)
    before = shipped_one.alarm_limits if shipped_one else None
    written = {key: _written(key, value, before) for key, value in keys.items()}

    def accept(catalog: Catalog) -> None:
        after = _named(catalog, channel.name)
        for key, value in keys.items():
            if value is not None and _effect(after, key) != _wanted(key, value):
                raise UsageError(problem=_OVERRIDDEN)

    return _change(own, channel, written, accept)


def reset_keys(own: OwnCatalog, known: Catalog, name: str, keys: Iterable[str]) -> Catalog:
    """Remove these of `KEYS` from the own file, and return the catalog then. Raises as `set_keys`.

    Limits keep what the page does not show: their source and confidence.
    """
    channel = _named(known, name)
    gone = {key: dict.fromkeys(_LIMITS) if key == "limits" else None for key in keys}
    return _change(own, channel, gone)


def set_channel(
    own: OwnCatalog, known: Catalog, name: str, keys: Mapping[str, Any], *, new: bool
) -> Catalog:
    """Add a derived channel, or change one of the own file; return the catalog then.

    `keys` as in the file; None: without that key. Raises `UsageError` for a name that is taken, or
    is not a channel's of the file, and as `OwnCatalog.change`.
    """
    try:
        name = mnemonic(name)
    except UsageError as error:
        raise usage_error(f"“{name}” {error.reason.en}", f"«{name}»: {error.reason.ru}") from None
    if new and name in known.channels.keys() | shipped().derived.keys():
        raise usage_error(
            f"There is a channel {name} already; choose another name",
            f"Канал {name} уже есть; выберите другое имя",
        )
    if not new:
        _own_channel(own, known, name)
    text, limits = keys["text"], keys.get("limits")
    same = text["en"] == text["ru"]
    # As a whole: constants and limits that are left out are gone.
    before = known.derived[name].constants if name in known.derived else ()
    tables = {
        "constants": {**dict.fromkeys(dict(before)), **keys.get("constants", {})},
        "limits": _limits(limits or {}, None),
    }
    keys = {
        **keys,
        "formula": _with_mnemonics(keys["formula"], dict(keys.get("constants") or {}), known),
    }
    written = {**keys, "text": text["en"] if same else dict(text), **tables}
    return own.change(lambda file: with_keys(file, "derived", name, written, file=str(own.path)))


def _with_mnemonics(formula: str, constants: Mapping[str, float], known: Catalog) -> str:
    """Return the formula with the channels' own names: other names may change with a version."""
    try:
        return parse(formula, constants, known.input_of).text
    except FormulaError:
        return formula  # the catalog's reader says what is wrong with it


def remove_channel(own: OwnCatalog, known: Catalog, name: str) -> Catalog:
    """Remove a derived channel from the own file, and return the catalog then.

    Raises `UsageError` if it is not a channel of that file, or another one needs it.
    """
    name = _own_channel(own, known, name)
    users = [each.name for each in known.derived.values() if name in each.inputs]
    if users:
        names = ", ".join(users)
        raise usage_error(
            f"{name} is needed by {names}; change or delete that first",
            f"{name} нужен каналу {names}; сначала измените или удалите его",
        )
    return own.change(lambda file: without(file, "derived", name, file=str(own.path)))


def is_own(own: OwnCatalog, channel: Parameter | Derived) -> bool:
    """Return whether the own file defines the whole derived channel."""
    return (
        isinstance(channel, Derived)
        and channel.name not in shipped().derived
        and "formula" in own.entries().get(("derived", channel.name), {})
    )


def _named(known: Catalog, name: str) -> AnyChannel:
    """Return the channel of this name; a raw code has no entry."""
    if (beside := known.instruments.get(name.upper())) is not None:
        return beside
    channel = known.channel(name)
    if isinstance(channel, Parameter) and channel not in known.parameters:
        raise UnknownParameter(name)
    return channel


def _own_channel(own: OwnCatalog, known: Catalog, name: str) -> str:
    channel = known.channel(name)
    if not is_own(own, channel):
        raise usage_error(
            f"{channel.name} is not a channel of your own catalog",
            f"{channel.name} — не канал вашего каталога",
        )
    return channel.name


def _change(
    own: OwnCatalog,
    channel: AnyChannel,
    keys: Mapping[str, Any],
    accept: Callable[[Catalog], object] = lambda _: None,
) -> Catalog:
    family = "derived" if isinstance(channel, Derived) else "parameter"
    if isinstance(channel, InstrumentChannel):
        family = "instrument"
    return own.change(
        lambda text: with_keys(text, family, channel.name, keys, file=str(own.path)), accept
    )


def _written(key: str, value: Any, before: AlarmLimits | None) -> Any:  # noqa: ANN401  (any key's)
    if key != "limits":
        return _plain(value)
    return dict.fromkeys(_LIMITS) if value is None else _limits(value, before)


def _limits(wanted: Mapping[str, Any], before: AlarmLimits | None) -> dict[str, Any]:
    """Return the keys of `limits` that make `wanted` out of the shipped limits."""
    before = before or AlarmLimits()
    return {
        key: None if value == getattr(before, key) else False if value is None else _plain(value)
        for key, value in _complete(wanted).items()
    }


def _complete(limits: Mapping[str, Any]) -> dict[str, Any]:
    """Return `limits` with all of its keys."""
    hysteresis, when_true = limits.get("hysteresis") or 0, limits.get("when_true") or Level.NONE
    own = {"hysteresis": hysteresis, "when_true": str(when_true)}
    return {key: own.get(key, limits.get(key)) for key in _LIMITS}


def _plain(value: Any) -> Any:  # noqa: ANN401  (a value of TOML)
    """Return whole numbers as such, and lists."""
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _effect(channel: AnyChannel, key: str) -> object:
    if key != "limits":
        return getattr(channel, key, None)
    return _wanted(key, {name: getattr(channel.alarm_limits, name, None) for name in _LIMITS})


def _wanted(key: str, value: Any) -> object:  # noqa: ANN401  (any key's)
    if key != "limits":
        return tuple(value) if isinstance(value, list | tuple) else value
    named = _complete(value)
    if not any(named[name] is not None for name in LIMITS):
        named["hysteresis"] = 0  # of no limits
    return named
