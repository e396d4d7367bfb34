"""What a shell is offered for an option's value or an argument.

Each function has click's signature of `shell_complete`. Modules are imported when they are needed.
A list (`leak:8,battery`) is completed behind its last comma.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Final

import click
from click.shell_completion import CompletionItem

if TYPE_CHECKING:
    from mikas.catalog import Catalog

Offers = list[CompletionItem]
Offering = Callable[[click.Context, click.Parameter, str], Offers]

RECORDING: Final = ("pcapng", "gz", "bz2", "xz", "lzma", "zip", "zst", "lz4", "7z")
"""Endings of recordings, also packed ones (`mikas.recording.capture.packed`)."""
UNIT: Final = ("zip", "json")
"""Endings of the file of a unit's profile."""
EXPORTED: Final = ("csv", "mf4", "parquet", "msl", "mlg", "gpx", "geojson")
_AFTER_SCHEME: Final = {"socket": "socket://", "rfc2217": "rfc2217://"}


def files(*endings: str) -> Offering:
    """Return what offers files with these endings of names, any without one; and folders."""

    def offer(_: click.Context, __: click.Parameter, ___: str) -> Offers:
        return [_files(endings)]

    return offer


def folders(_: click.Context, __: click.Parameter, ___: str) -> Offers:
    """Offer folders."""
    return [CompletionItem("", type="dir")]


def words(*known: str) -> Offering:
    """Return what offers `known`; behind one that ends with a sign, something follows."""
    return listed(lambda: known)


def listed(known: Callable[[], Iterable[str]]) -> Offering:
    """As `words`, of what `known` returns; it is not called before a shell asks."""

    def offer(_: click.Context, __: click.Parameter, incomplete: str) -> Offers:
        return _begun(dict.fromkeys(known(), ""), incomplete)

    return offer


def _begun(known: Mapping[str, str] | Iterable[str], incomplete: str, before: str = "") -> Offers:
    """Return those of `known` that begin so, behind `before`; a mapping has descriptions.

    Behind one that ends with a sign, something follows without a blank.
    """
    helps = known if isinstance(known, Mapping) else dict.fromkeys(known, "")
    return [
        CompletionItem(
            before + it, type="plain" if it[-1:].isalnum() else "open", help=text.split("\n")[0]
        )
        for it, text in helps.items()
        if it.casefold().startswith(incomplete.casefold())
    ]


def _files(endings: Iterable[str], begin: str = "") -> CompletionItem:
    return CompletionItem(",".join(endings), type="file", begin=begin)


def channel_names(ctx: click.Context, parameter: click.Parameter, incomplete: str) -> Offers:
    """Offer the mnemonics that begin so, then other names («обороты», `rpm`) with theirs.

    Those that the line has already are left out. A formula may name instruments' channels, too.
    """
    from mikas.cli.language import localized

    catalog = _catalog(ctx)
    given = ctx.params.get(parameter.name or "") or ()
    beside = catalog.instruments if parameter.name == "expression" else {}
    known = {
        name: localized(channel.short)
        for name, channel in (*catalog.channels.items(), *beside.items())
        if name not in given
    }
    offers = _begun(known, incomplete)
    if incomplete:
        begin = incomplete.casefold().replace("ё", "е")
        offers += [
            CompletionItem(other, help=name)
            for other, name in catalog.synonyms.items()
            if other.startswith(begin)
        ]
    return offers


def evidence_names(ctx: click.Context, _: click.Parameter, incomplete: str) -> Offers:
    """Offer clauses, channels and so on, and surveys; a fault and a model by their numbers."""
    from mikas.catalog.grounds import grounds_of
    from mikas.cli.language import localized

    every = grounds_of(_catalog(ctx))
    known = {each.name.rpartition(" ")[2]: localized(each.text) for each in every}
    return [*_begun(known, incomplete), _files(["zip"])]


def fault_codes(ctx: click.Context, _: click.Parameter, incomplete: str) -> Offers:
    """Offer the numbers of faults, in a list with commas."""
    from mikas.cli.language import localized

    texts = {str(code): localized(it.text) for code, it in _catalog(ctx).faults.items()}
    begin, last = _last(incomplete, ",")
    return _begun(texts, last, begin)


def ports(_: click.Context, __: click.Parameter, incomplete: str) -> Offers:
    """Offer the adapters that are there, and the beginnings of other ports."""
    scheme, colon, rest = incomplete.partition(":")
    if colon and scheme == "replay":
        return [_files(RECORDING, "replay:")]
    if colon and scheme == "sim":
        return _virtual_unit(rest)
    from mikas.link.ports import find_ports
    from mikas.link.urls import registered

    offers = _begun({it.url: it.description for it in find_ports()}, incomplete)
    schemes = sorted(set(registered()) - {"serial"})
    return offers + _begun([_AFTER_SCHEME.get(it, f"{it}:") for it in schemes], incomplete)


def instruments(ctx: click.Context, param: click.Parameter, incomplete: str) -> Offers:
    """Offer the instruments beside the unit, and behind `=` their ports."""
    from mikas.instruments import definition_named, definition_names

    name, equals, port = incomplete.partition("=")
    if not equals:
        known = {f"{it}=": definition_named(it).text.en for it in definition_names()}
        return [*_begun(known, incomplete), _files(["toml"])]
    offers = _begun(["gpsd:localhost:2947"] if name.endswith("gpsd") else [], port, f"{name}=")
    for each in ports(ctx, param, port):
        if each.type not in ("file", "dir"):  # a recording has no instrument that could be read
            offers.append(CompletionItem(f"{name}={each.value}", type=each.type, help=each.help))
    return offers


def _virtual_unit(options: str) -> Offers:
    """Offer the options of `sim:`, each behind ? or &, and their values."""
    from mikas.virtual.build import SETTINGS

    if not options.startswith("?"):
        return _begun(["sim:?"], f"sim:{options}")
    sign = max(options.rfind("?"), options.rfind("&")) + 1
    begin, last = f"sim:{options[:sign]}", options[sign:]
    name, equals, value = last.partition("=")
    if equals:
        if name == "unit":
            return [_files(UNIT, f"{begin}{name}=")]
        return _begun(_values_of(name), value, f"{begin}{name}=")
    return _begun([f"{it}=" for it in ("clock", *SETTINGS)], last, begin)


def _values_of(setting: str) -> Mapping[str, str] | Iterable[str]:
    from mikas.virtual.build import MODELS

    match setting:
        case "scenario":
            return _scenarios()
        case "model":
            return [*MODELS]
        case "clock":
            return ("real", "simulated")
    return ()


def scenarios(_: click.Context, __: click.Parameter, incomplete: str) -> Offers:
    """Offer the shipped scenarios, and files."""
    return [*_begun(_scenarios(), incomplete), _files(["toml"])]


def _scenarios() -> Mapping[str, str]:
    from mikas.cli.language import localized
    from mikas.virtual.scenarios.scenario import SCENARIOS

    return {name: localized(it.text) for name, it in SCENARIOS.items()}


def cars(_: click.Context, __: click.Parameter, incomplete: str) -> Offers:
    """Offer the defects of a virtual car, in a list with commas."""
    from mikas.cli.language import localized
    from mikas.virtual.defects.choosing import KEYS
    from mikas.virtual.defects.table import DEFECTS

    begin, last = _last(incomplete, ",")
    alone = {} if begin else {"healthy": "", "blind:": ""}
    return _begun(
        alone
        | {key: " / ".join(localized(side.text) for side in DEFECTS[key].sides) for key in KEYS},
        last,
        begin,
    )


def line_faults(_: click.Context, __: click.Parameter, incomplete: str) -> Offers:
    """Offer the faults of the line: `damaged=`."""
    from mikas.virtual.fault_injector import LineFault

    return _begun([f"{it.value}=" for it in LineFault], incomplete)


def unit_settings(_: click.Context, __: click.Parameter, incomplete: str) -> Offers:
    """Offer the settings of a virtual unit: `unknown=`."""
    from mikas.virtual.build import SETTINGS

    return _begun([f"{it}=" for it in SETTINGS], incomplete)


def methods(_: click.Context, __: click.Parameter, incomplete: str) -> Offers:
    """Offer the methods of sampling."""
    from mikas.client import METHODS

    return _begun(["auto", *METHODS], incomplete)


def guided_tests(ctx: click.Context, _: click.Parameter, incomplete: str) -> Offers:
    """Offer the guided tests, also the user's own."""
    from mikas.cli.config import own_tests
    from mikas.cli.language import localized
    from mikas.guided.loading import load

    tests = load(_catalog(ctx), own_tests()).tests
    return _begun({name: localized(it.title) for name, it in tests.items()}, incomplete)


def steps_of_test(ctx: click.Context, _: click.Parameter, incomplete: str) -> Offers:
    """Offer the steps of the test that the line names."""
    from mikas.cli.config import own_tests
    from mikas.guided.loading import load

    test = load(_catalog(ctx), own_tests()).tests.get(ctx.params.get("name") or "")
    return _begun([step.name for step in test.steps] if test else [], incomplete)


def _last(text: str, sign: str) -> tuple[str, str]:
    """Return `text` up to its last `sign`, and the rest."""
    begin, found, last = text.rpartition(sign)
    return begin + found, last


def _catalog(ctx: click.Context) -> Catalog:
    """Return the catalog with the user's own, and with the files that the line names."""
    from pathlib import Path

    from mikas.catalog import shipped
    from mikas.catalog.own.file import OwnCatalog
    from mikas.cli.config import own_catalog
    from mikas.errors import MikasError

    named = tuple(map(Path, ctx.find_root().ensure_object(dict).get("catalog") or ()))
    try:
        return OwnCatalog(own_catalog(), named).load().catalog
    except (MikasError, OSError):
        return shipped()
