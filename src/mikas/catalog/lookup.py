"""The catalog: entries by name, by code, by number (§3, §4).

An unknown name is an error with the nearest names; an unknown number is a valid value (a fault
without text, an unknown model), for an ECU may answer any number.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

from mikas.catalog.conversion import Conversion
from mikas.catalog.instrument_channels import InstrumentChannel, is_labelled
from mikas.catalog.model import Derived, Erratum, Fault, Model, Parameter, in_order
from mikas.catalog.synonyms import Named, named, normal, synonyms_of
from mikas.errors import UnknownParameter
from mikas.i18n import Text
from mikas.options import in_latin, nearest

_RAW_CODE = re.compile(r"0x([0-9a-f]{1,2})(?::([0-9]{1,3}))?", re.IGNORECASE)
_RAW_SIZES = (1, 2, 3, 4)
_COMPUTED = Text(
    "It is a derived channel, computed from {inputs}: read it, or sample it in a session.",
    "Это производный канал, он вычисляется из {inputs}: прочитайте его (read) или ведите опрос.",
)
_BESIDE = Text(
    "It is a channel of an instrument beside the unit: an instrument that gives it comes with "
    "--instrument NAME=URL, as {example}.",
    "Это канал прибора рядом с блоком: прибор, который его даёт, подключает --instrument "
    "ИМЯ=АДРЕС, например {example}.",
)


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Catalog:
    """All definitions, immutable. Parameters and `derived` channels share one name space.

    `units` has the text of each unit by key; `version` identifies the loaded files.
    """

    parameters: tuple[Parameter, ...]
    """In the order of §4, the user's own after them."""
    derived: Mapping[str, Derived]
    """The derived channels by name."""
    instruments: Mapping[str, InstrumentChannel] = field(default_factory=dict)
    """The channels of instruments beside the unit, by name."""
    beside: Mapping[str, InstrumentChannel] = field(default_factory=dict)
    """Those that a session or a recording has, with their labels; a formula may name them."""
    faults: Mapping[int, Fault]
    """The faults by number."""
    models: Mapping[int, Model]
    """The models by version code."""
    errata: Mapping[str, Erratum]
    """The doubtful passages by name, E1."""
    units: Mapping[str, Text]
    """The text of each unit by key."""
    version: str
    """Of the loaded files, with a mark of their content."""

    @cached_property
    def _by_name(self) -> dict[str, Parameter]:
        return {parameter.name: parameter for parameter in self.parameters}

    @cached_property
    def channels(self) -> Mapping[str, Parameter | Derived]:
        """All parameters and derived channels by name, in the order of the tables."""
        return {**self._by_name, **self.derived}

    @cached_property
    def synonyms(self) -> Mapping[str, str]:
        """The channel of each other name that people use, as `synonyms.normal` returns it."""
        return synonyms_of(
            Named(each.name, each.text, each.short) for each in self.channels.values()
        )

    @cached_property
    def other_names(self) -> Mapping[str, list[str]]:
        """The names in `synonyms`, by channel."""
        found: dict[str, list[str]] = {}
        for other, name in self.synonyms.items():
            found.setdefault(name, []).append(other)
        return found

    def channel_of(self, word: str) -> str:
        """Return the channel that a word means («обороты»); in capitals if it means none."""
        return named(word.strip(), self.channels, self.synonyms)

    @cached_property
    def _sizes(self) -> dict[int, int]:
        return {parameter.code: parameter.size for parameter in self.parameters}

    @cached_property
    def _sharing(self) -> dict[int, tuple[Parameter, ...]]:
        found: dict[int, tuple[Parameter, ...]] = {}
        for parameter in self.parameters:
            found[parameter.code] = (*found.get(parameter.code, ()), parameter)
        return found

    @property
    def codes(self) -> tuple[tuple[int, int], ...]:
        """Each distinct code with its size, in the order of the table."""
        return tuple(self._sizes.items())

    def size_of(self, code: int) -> int | None:
        """Return the number of raw bytes of a code; None if unknown."""
        return self._sizes.get(code)

    def by_code(self, code: int) -> tuple[Parameter, ...]:
        """Return the parameters that share a code (07 has three flags)."""
        return self._sharing.get(code, ())

    def parameter(self, name: str) -> Parameter:
        """Return a parameter by name in any case, by another name that people use, or by code.

        A code is `0x1A`, with 1 to 4 bytes `0x3F:2`.

        A code gives the raw number without unit; its default size is the catalog's, or 1. Raises
        `UnknownParameter` (with the nearest names) otherwise, also for a derived channel.
        """
        name = name.strip()
        meant = self.channel_of(name)
        if (computed := self.derived.get(meant)) is not None:
            error = UnknownParameter(name)
            error.advice = _COMPUTED.filled(inputs=", ".join(computed.inputs))
            raise error
        return self._by_name.get(meant) or self._by_code(name, self._by_name)

    def channel(self, name: str) -> Parameter | Derived:
        """As `parameter`, and also return a derived channel by name in any case."""
        name = name.strip()
        return self.channels.get(self.channel_of(name)) or self._by_code(name, self.channels)

    def described(self, name: str) -> Parameter | Derived | InstrumentChannel | None:
        """Return the channel of a column's very name; of an instrument's also with its label.

        None for one that only the instrument's own definition describes.
        """
        if found := self.channels.get(name) or self.instruments.get(name):
            return found
        alike = [own for own in self.instruments if is_labelled(name, own)]
        return self.instruments[max(alike, key=len)] if alike else None

    def with_beside(self, channels: Iterable[InstrumentChannel]) -> Catalog:
        """Return the same catalog for a session or a recording with these instruments' channels."""
        return replace(self, beside={channel.name: channel for channel in channels})

    @cached_property
    def formula_channels(self) -> Mapping[str, Parameter | Derived | InstrumentChannel]:
        """All channels that a formula may name, by name."""
        return {**self.instruments, **self.beside, **self.channels}

    def input_of(self, word: str) -> str:
        """Return the channel that a word of a formula means; in capitals if it means none.

        An instrument's own name is not taken for another name of a channel of the unit: `LAMBDA` is
        the λ meter's, and so is `Lambda` where there is one; else that is the unit's VALF.
        """
        word = word.strip()
        own = word.upper()
        return own if own in self.beside or word in self.instruments else self.channel_of(word)

    def formula_channel(self, name: str) -> Parameter | Derived | InstrumentChannel:
        """As `channel`, and also return an instrument's."""
        known = self.formula_channels
        return known.get(self.input_of(name)) or self._by_code(name.strip(), known)

    def _by_code(self, name: str, known: Iterable[str]) -> Parameter:
        if match := _RAW_CODE.fullmatch(name):
            return self._raw(name, int(match[1], 16), match[2])
        if _RAW_CODE.fullmatch(in_latin(name)):
            raise UnknownParameter(name, (in_latin(name),))
        if isinstance(self.described(name.upper()), InstrumentChannel):
            raise self.not_beside(name)
        raise UnknownParameter(name, nearest(name, known, 3) or self._alike(name, known))

    def not_beside(self, name: str) -> UnknownParameter:
        """Return the error of an instrument's channel where no instrument gives it."""
        error = UnknownParameter(name)
        kind = "nmea" if name.upper().startswith("GPS_") else "aem"
        error.advice = _BESIDE.filled(example=f"{kind}=/dev/ttyUSB1")
        return error

    def _alike(self, name: str, known: Iterable[str]) -> tuple[str, ...]:
        """Return the channels of other names that are almost `name`."""
        from difflib import get_close_matches

        words = get_close_matches(normal(name), self.synonyms, 3, 0.75)
        return tuple({self.synonyms[word]: None for word in words if self.synonyms[word] in known})

    def _raw(self, name: str, code: int, given: str | None) -> Parameter:
        size = int(given) if given else self._sizes.get(code, 1)
        if size not in _RAW_SIZES:
            raise UnknownParameter(name, [f"0x{code:02X}:{size}" for size in _RAW_SIZES])
        return Parameter(
            name=f"0x{code:02X}:{size}" if given else f"0x{code:02X}",
            code=code,
            text=Text(f"raw number of code 0x{code:02X}", f"исходное число кода 0x{code:02X}"),
            conversion=Conversion(size),
        )

    @cached_property
    def _needs(self) -> dict[str, int]:
        """The parameters that each channel needs, as bits by their place in the table.

        All at once, so that a chain of channels is as much work as the same number of others.
        """
        needs = {parameter.name: 1 << place for place, parameter in enumerate(self.parameters)}
        for channel in in_order(self.derived, self.derived):
            bits = 0
            for name in channel.inputs:
                bits |= needs.get(name, 0)
            needs[channel.name] = bits
        return needs

    @cached_property
    def _required(self) -> dict[int, tuple[str, ...]]:
        """The names of parameters by their bits: many channels need the same."""
        return {}

    def required_by(self, names: Iterable[str]) -> tuple[str, ...]:
        """Return the parameters that these channels need, in the order of the table.

        An instrument's channel needs none.
        """
        names, bits = tuple(names), 0
        for name in names:
            bits |= self._needs.get(name, 0)
        if (found := self._required.get(bits)) is None:
            digits = zip(self.parameters, reversed(f"{bits:b}"), strict=False)
            found = tuple(parameter.name for parameter, digit in digits if digit == "1")
            if len(names) == 1:  # else a client could name ever other ones
                self._required[bits] = found
        return found

    @cached_property
    def _needs_beside(self) -> dict[str, frozenset[str]]:
        """The instruments' channels that each derived channel needs."""
        needs: dict[str, frozenset[str]] = {}
        for channel in in_order(self.derived, self.derived):
            own = (name for name in channel.inputs if name not in self.channels)
            needs[channel.name] = frozenset(own).union(
                *(needs[name] for name in channel.inputs if name in needs)
            )
        return needs

    def required_beside(self, names: Iterable[str]) -> tuple[str, ...]:
        """Return the instruments' channels that these channels are or need, in alphabetic order."""
        found: set[str] = set()
        for name in names:
            found |= self._needs_beside.get(name, frozenset())
            if name in self.formula_channels and name not in self.channels:
                found.add(name)
        return tuple(sorted(found))

    def same_channels(self, other: Catalog) -> frozenset[str]:
        """Return the channels of which both catalogs make the same values from the same bytes.

        Texts, limits and decimals may differ.
        """
        same = {
            name
            for name, one in self._by_name.items()
            if (two := other._by_name.get(name))
            and (one.code, one.interpretations) == (two.code, two.interpretations)
        }
        beside = self.instruments.keys() & other.instruments.keys()
        for derived in in_order(self.derived, self.derived):
            before = other.derived.get(derived.name)
            if (
                before is not None
                and (derived.formula, derived.constants, derived.accumulates)
                == (before.formula, before.constants, before.accumulates)
                and beside.union(same).issuperset(derived.inputs)
            ):
                same.add(derived.name)
        return frozenset(same)

    def fault(self, code: int) -> Fault:
        """Return the fault of that number; an unknown one has no text."""
        return self.faults.get(code) or Fault(code)

    def model(self, code: int) -> Model:
        """Return the model with this answer to 01; an unknown one is named by the number."""
        return self.models.get(code) or Model.unknown(code)


def is_corrected(channel: Parameter | Derived, interpretation: str) -> bool:
    """Return whether `interpretation` gives the same values as the corrected one, of formulas."""
    if isinstance(channel, Derived):
        return True  # always computed from corrected values
    return channel.interpretation(interpretation) == channel.conversion
