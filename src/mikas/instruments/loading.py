"""Read definitions: the shipped ones, a file of the user's, another distribution's, a recording's.

    text = "AEM X-Series"
    decoder = "line"
    baud = 9600
    patterns = ["{AFR}"]

A channel that the catalog lacks has a table `[instrument.NAME]` in the file, as in a catalog's. A
wrong file is an error with file and line (`CatalogError`).
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from mikas.catalog import Catalog, InstrumentChannel, shipped
from mikas.catalog.limits import Confidence
from mikas.catalog.loading.build import instrument_channel
from mikas.catalog.loading.entries import merged
from mikas.catalog.loading.fields import (
    ANY,
    CONFIDENCE,
    FAMILIES,
    TEXT,
    Schema,
    between,
    choice,
    integer,
    positive,
    read_table,
    string,
    strings,
)
from mikas.catalog.loading.source import CatalogFile, parse_source, read_source
from mikas.distributions import entries_of, loaded, unfit
from mikas.errors import CatalogError, UsageError
from mikas.i18n import Text
from mikas.instruments.decoders.patterns import LinePattern
from mikas.instruments.decoding import CHANNELS, GROUP, LINE, unknown_decoder
from mikas.instruments.definition import STOICHIOMETRIC, InstrumentDefinition
from mikas.options import with_nearest

_NAME: Final = re.compile(r"[a-z0-9][a-z0-9-]{0,39}")
_LONGEST_TEXT: Final = 60_000  # bytes of a file: a recording keeps it in one option of pcapng
_SHIPPED: Final = Path(__file__).parent / "shipped"
_SCHEMA: Final[Schema] = {
    "text": TEXT,
    "decoder": string,
    "baud": integer(50, 4_000_000),
    "patterns": strings,
    "channels": strings,
    "decimal": choice(str, ".", ","),
    "stoichiometric": between(1, 50),
    "stale": positive,
    "source": string,
    "confidence": CONFIDENCE,
    "instrument": {ANY: FAMILIES["instrument"].schema},
}


def definition_names() -> tuple[str, ...]:
    """Return the names of the shipped definitions and of other distributions'."""
    own = (path.stem for path in _SHIPPED.glob("*.toml"))
    return tuple(sorted({*own, *entries_of(GROUP)}))


def definition_named(name: str, catalog: Catalog | None = None) -> InstrumentDefinition:
    """Return the definition `aem`, or that in the file `my.toml`.

    Raises `CatalogError` for a wrong file, `UsageError` for a name that is not known.
    """
    if name.lower().endswith(".toml"):
        return _definition(read_source(Path(name)), Path(name).stem.lower(), catalog)
    wanted = name.lower()
    path = _SHIPPED / f"{wanted}.toml"
    if _NAME.fullmatch(wanted) and path.is_file():
        return _definition(read_source(path), wanted, catalog)
    if entries := entries_of(GROUP).get(wanted):
        found = loaded(wanted, entries)
        text = getattr(found, "definition", found)
        if not isinstance(text, str):
            problem = Text("has no text `definition`", "нет текста `definition`")
            raise unfit(wanted, entries, problem)
        return definition_of_text(wanted, text, catalog)
    known = definition_names()
    listed = ", ".join(known)
    problem = Text(
        f"There is no instrument “{name}”; there are: {listed}, or a file of yours: my.toml",
        f"Прибора «{name}» нет; есть: {listed}, или ваш файл: my.toml",
    )
    raise UsageError(problem=with_nearest(problem, wanted, known))


def definition_of_text(
    name: str, text: str, catalog: Catalog | None = None
) -> InstrumentDefinition:
    """Return the definition in a text, as a recording or another distribution has it.

    Raises `CatalogError`.
    """
    return _definition(parse_source(f"{name}.toml", text.encode()), name, catalog)


def _definition(source: CatalogFile, name: str, catalog: Catalog | None) -> InstrumentDefinition:
    form = read_table(source, (), source.tables, _SCHEMA)
    if not _NAME.fullmatch(name):
        raise source.error(
            (),
            "the file is named by small Latin letters, digits and hyphens: my-meter.toml",
            "имя файла прибора — строчные латинские буквы, цифры и дефисы: my-meter.toml",
        )
    if len(source.text.encode()) > _LONGEST_TEXT:
        raise source.error((), "the file is longer than 60,000 bytes", "файл длиннее 60 000 байт")
    for key in ("text", "decoder"):
        if not form.get(key):
            raise source.error((), f"has no `{key}`", f"нет `{key}`")
    for key in ("en", "ru"):
        if key not in form["text"]:
            raise source.wrong(("text",), Text(f"has no `{key}`", f"нет `{key}`"))
    decoder, patterns = form["decoder"], form.get("patterns", ())
    if decoder not in (LINE, *CHANNELS, *entries_of(GROUP)):
        problem = unknown_decoder(decoder).reason
        raise source.error(("decoder",), problem.en, problem.ru)
    if (decoder == LINE) != bool(patterns):
        raise source.error(
            ("patterns",) if patterns else ("decoder",),
            "`patterns` belong to the decoder line, and it needs one at least",
            "`patterns` есть только у декодера line, и хотя бы один ему нужен",
        )
    given = form.get("decimal", ".")
    channels = _channels(source, form, _names(source, form, given), catalog or shipped())
    return InstrumentDefinition(
        name=name,
        text=Text(**form["text"]),
        decoder=decoder,
        channels=channels,
        baud=form.get("baud", 9600),
        patterns=patterns,
        decimal=given,
        stoichiometric=form.get("stoichiometric", STOICHIOMETRIC),
        stale=float(form.get("stale", 1.0)),
        source=form.get("source", ""),
        confidence=Confidence(form.get("confidence", Confidence.UNCONFIRMED)),
        toml=source.text,
    )


def _names(source: CatalogFile, form: Mapping[str, Any], decimal: str) -> tuple[str, ...]:
    """Return the names of the channels that the decoder gives."""
    decoder = form["decoder"]
    if "channels" in form:
        names = [name.upper() for name in form["channels"]]
    elif decoder == LINE:
        names = []
        for pattern in form["patterns"]:
            try:
                names += LinePattern(pattern, decimal).names
            except UsageError as error:
                raise source.wrong(("patterns",), error.reason) from None
    elif decoder in CHANNELS:
        names = [*CHANNELS[decoder]]
    else:
        raise source.error(("decoder",), "has no `channels`", "нет `channels`")
    if {"LAMBDA", "AFR"} & {*names} and "channels" not in form:
        names += ["LAMBDA", "AFR"]
    return tuple(dict.fromkeys(names))


def _channels(
    source: CatalogFile, form: Mapping[str, Any], names: tuple[str, ...], catalog: Catalog
) -> tuple[InstrumentChannel, ...]:
    own: dict[str, InstrumentChannel] = {}
    tables = {"instrument": source.tables.get("instrument", {})}
    for name, entry in merged([CatalogFile(source.name, source.text, tables)])[
        "instrument"
    ].items():
        own[name] = instrument_channel(name, entry, catalog.units)
    found = []
    for name in names:
        channel = own.get(name) or catalog.instruments.get(name)
        if channel is None or name in catalog.channels:
            raise _no_channel(source, form, name, taken=name in catalog.channels)
        found.append(channel)
    return tuple(found)


def _no_channel(
    source: CatalogFile, form: Mapping[str, Any], name: str, *, taken: bool
) -> CatalogError:
    key = "channels" if "channels" in form else "patterns" if "patterns" in form else "decoder"
    if taken:
        problem = Text(
            f"names {name}, which the unit itself sends; choose another name",
            f"имя {name} занято каналом самого блока; выберите другое",
        )
    else:
        problem = Text(
            f"names {name}, which is not described; add a table [instrument.{name}] with its text",
            f"канал {name} не описан; добавьте таблицу [instrument.{name}] с его text",
        )
    return source.wrong((key,), problem)
