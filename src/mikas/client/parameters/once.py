"""Named channels that are read once: the parameters of all requests, and the values they give.

A derived channel is computed by the code of samples and recordings (`derived`), from parameters
that are read with the others, in as few requests as the unit takes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import nan

from mikas.catalog import Catalog, Derived, Parameter
from mikas.catalog.model import in_order
from mikas.client.parameters.data import refused
from mikas.client.parameters.derived import DerivedChannels, DerivedValue
from mikas.client.parameters.readings import Reading
from mikas.errors import NeedsSamples, NotSupported, usage_error
from mikas.i18n import Text


def check_names(names: Sequence[str]) -> None:
    """Raise `UsageError` unless the names are words."""
    for name in names:
        if not isinstance(name, str):
            raise usage_error(
                f"names are given one by one, as in read('TWAT', 'FREQ'), not {name!r}",
                f"имена даются по одному: read('TWAT', 'FREQ'), а не {name!r}",
            )


class Once:
    """The channels of `names`; of no names, all parameters of the catalog.

    `parameters`: those to read, each once. Raises `UnknownParameter`, and `NeedsSamples` for a
    channel that is added up over time.
    """

    def __init__(self, catalog: Catalog, names: Sequence[str]) -> None:
        check_names(names)
        self._catalog = catalog
        self._is_named = bool(names)
        self._channels = tuple(map(catalog.channel, names)) or catalog.parameters
        self._derived = [each for each in self._channels if isinstance(each, Derived)]
        for channel in self._derived:
            _check_needs_no_samples(catalog, channel)
        parameters = {each.name: each for each in self._channels if isinstance(each, Parameter)}
        for name in catalog.required_by(each.name for each in self._derived):
            parameters.setdefault(name, catalog.parameter(name))
        self.parameters: tuple[Parameter, ...] = tuple(parameters.values())

    def values(self, readings: Mapping[str, Reading]) -> dict[str, Reading | DerivedValue]:
        """Return the value of each channel, in the order of the names.

        Raises `NotSupported` for a named channel without a reading, or without one that it needs,
        and if there is none at all.
        """
        computed = self._computed(readings) if self._derived else {}
        found: dict[str, Reading | DerivedValue] = {}
        for channel in self._channels:
            if isinstance(channel, Derived):
                found[channel.name] = computed[channel.name]
            elif channel.name in readings:
                found[channel.name] = readings[channel.name]
            elif self._is_named or not readings:
                raise refused(channel.name, channel.code)
        return found

    def _computed(self, readings: Mapping[str, Reading]) -> dict[str, DerivedValue]:
        found: dict[str, DerivedValue] = {}
        for channel in self._derived:
            needed = self._catalog.required_by([channel.name])
            if missing := [name for name in needed if name not in readings]:
                raise _lacks(channel, [self._catalog.parameter(name) for name in missing])
            inputs = {name: readings[name] for name in needed}
            times = [each.time for each in (inputs or readings).values()]
            # The number of a formula without any parameter has the time of what was read with it.
            time = min(times, default=0.0)
            value = DerivedChannels(self._catalog, [channel.name]).update(inputs, time)
            found[channel.name] = value.get(channel.name) or DerivedValue(
                channel, nan, channel.unit, time, inputs
            )
        return found


def _check_needs_no_samples(catalog: Catalog, channel: Derived) -> None:
    for each in in_order(catalog.derived, [channel.name]):
        if each.accumulates:
            raise NeedsSamples(name=channel.name, total=each.name)
    if beside := catalog.required_beside([channel.name]):
        names = ", ".join(beside)
        raise usage_error(
            f"The unit alone can't give {channel.name}: {names} comes from an instrument. "
            "Sample it in a session with that instrument",
            f"Один блок не даст {channel.name}: {names} приходит с прибора. "
            "Опрашивайте его вместе с этим прибором",
        )


def _lacks(channel: Derived, missing: Sequence[Parameter]) -> NotSupported:
    """Return the error for a derived channel whose inputs the unit does not know."""
    codes = ", ".join(f"{each.name} (61 {each.code:02X})" for each in missing)
    several = len(missing) > 1
    command = Text(
        f"{'parameters' if several else 'parameter'} {codes}, needed for {channel.name}",
        f"{'параметров' if several else 'параметра'} {codes}: нужны для {channel.name}"
        if several
        else f"параметра {codes}, нужного для {channel.name}",
    )
    return NotSupported(command=command, request=bytes([0x61, missing[0].code]))
