"""Parameters by name: read, watched, listed, streamed, written (§3 rows 60–64, 71, 7F–83; §4)."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from mikas import commands as c
from mikas import errors
from mikas.catalog import Catalog, Parameter
from mikas.client.gate import Change, Gate
from mikas.client.parameters.data import DataReader
from mikas.client.parameters.derived import DerivedValue
from mikas.client.parameters.once import Once, check_names
from mikas.client.parameters.readings import Reading, Wanted, decode
from mikas.client.parameters.unit_list import UnitList, list_of
from mikas.commands.base import check_bytes
from mikas.i18n import Text, byte_count
from mikas.tester import Tester

if TYPE_CHECKING:
    from mikas.tester import Stream


@dataclass(frozen=True, slots=True)
class WrittenParameter:
    """The result of a parameter write. `before`, `after`: None if unreadable."""

    name: str
    """The parameter."""
    before: Reading | None
    after: Reading | None


@dataclass(slots=True, eq=False)
class Parameters:
    """Reads and writes parameters by name; the unit knows codes and bytes."""

    tester: Tester
    catalog: Catalog
    _interpretation: str
    _gate: Gate
    _data: DataReader
    unit_list: UnitList

    def named(self, names: Sequence[str]) -> tuple[Parameter, ...]:
        """Return the parameters of these names; without names, all of the catalog."""
        check_names(names)
        return tuple(map(self.catalog.parameter, names)) or self.catalog.parameters

    def read(self, names: Sequence[str]) -> dict[str, Reading | DerivedValue]:
        """As `Ecu.read`."""
        once = Once(self.catalog, names)
        readings = self.fetch(self.wanted(once.parameters), again=bool(names))
        return once.values(readings)

    def fetch(
        self, wanted: Wanted, *, single: bool = False, again: bool = False
    ) -> dict[str, Reading]:
        """Read `wanted`, each code once. Arguments and errors: `DataReader.read`."""
        return wanted.readings(self._data.read(wanted.data, single=single, again=again))

    def wanted(self, parameters: Sequence[Parameter]) -> Wanted:
        """Return `parameters`, to be read together."""
        return Wanted(parameters, self._interpretation)

    def announce(self, wanted: Wanted, *, listed: bool) -> None:
        """Announce (`Tester.announce`) the request that reads `wanted`, if it takes one.

        `listed`: the one that reads the unit's list, if it is set to `wanted`.
        """
        if not listed and (command := self._data.request_for(wanted.data)) is not None:
            self.tester.announce(command)
        if listed and self.unit_list.is_set_to(wanted.parameters):
            self.tester.announce(c.ReadList(list_of(wanted.parameters)))

    def at_once(self, parameters: Sequence[Parameter]) -> dict[str, Reading]:
        """Read `parameters` by one request; errors and result: `send_once`."""
        wanted = self.wanted(parameters)
        return wanted.readings(self._data.requests.send_once(wanted.data))

    def refuses(self, wanted: Sequence[Parameter]) -> bool:
        """Whether the unit is known to refuse every one of them."""
        return self._data.refuses(p.code for p in wanted)

    # Lists, 63 and 64

    def try_list(self, data: tuple[c.Datum, ...]) -> c.ReadList:
        """Set the last known list again, without one `data`; return the command that reads it.

        Raises `NotConfirmed`, `WriteRefused`, `NotSupported`, a `LineError` or a `NoConnection`.
        """
        with self.unit_list.held():
            kept: tuple[str, ...] = ()
            with suppress(errors.NoList):
                kept = self.unit_list.kept()
            known = self.unit_list.current
            with suppress(errors.UnknownParameter):  # the catalog has changed since
                known = known or (self.named(kept) if kept else ())
            if known:
                self.unit_list.set(known, keep=bool(kept))
                return c.ReadList(list_of(known))
            self.unit_list.try_out(data)
            return c.ReadList(data)

    def through_list(self, wanted: Wanted) -> dict[str, Reading]:
        """Read `wanted` by the unit's list, which is set first if it differs."""
        with self.unit_list.held():
            if not self.unit_list.is_set_to(wanted.parameters):
                self.unit_list.set(wanted.parameters)
            return wanted.readings(self.unit_list.read(wanted.parameters))

    def stream(self, wanted: Wanted, stroke: int | None) -> Stream:
        """Start the tester's stream of `wanted` (71, 7F … 83); the caller closes it."""
        data = wanted.data
        command = c.StreamCyclic(data) if stroke is None else c.StreamAtStroke(data, stroke)
        return self.tester.stream(command)

    def write(self, name: str, value: float | None, raw: bytes | None) -> WrittenParameter:
        """As `Ecu.write_parameter` (62)."""
        parameter = self.catalog.parameter(name)
        data = datum_to_write(parameter, value, raw, self._interpretation)
        before = self._one(parameter)
        what = Text(f"write parameter {parameter.name}", f"записать параметр {parameter.name}")
        new = decode(parameter, data, self.tester.link.now(), self._interpretation)
        change = Change.by(
            c.WriteParameter,
            what,
            before.raw if before else None,
            data,
            name=parameter.name,
            old=before.shown if before else None,
            new=new.shown,
            warning=KEEPING_UNKNOWN,
        )

        def act() -> WrittenParameter:
            try:
                self.tester.request(c.WriteParameter(parameter.code, data))
            except (errors.NoResponse, errors.NotSupported) as error:
                after = None if error.received else self._one(parameter)
                if not (before and after and before.raw != data == after.raw):
                    raise
                # The write succeeded; only the answer was lost.
            else:
                after = self._one(parameter)
            if after and after.raw != data:
                raise errors.ReadBackDiffers(
                    name=parameter.name,
                    wanted=errors.hex_dump(data),
                    got=errors.hex_dump(after.raw),
                )
            return WrittenParameter(parameter.name, before, after)

        return self._gate.make(change, act, lambda it: it.after.raw if it.after else None)

    def _one(self, parameter: Parameter) -> Reading | None:
        try:
            return self.fetch(self.wanted([parameter])).get(parameter.name)
        except errors.NotSupported:
            return None


KEEPING_UNKNOWN: Final = Text(
    "Whether the unit keeps this value when it loses its supply is unknown (§3).",
    "Сохранит ли блок это значение без питания, неизвестно (§3).",
)
"""Shown before a parameter is written: the source does not say it."""


def datum_to_write(
    parameter: Parameter, value: float | None, raw: bytes | None, interpretation: str
) -> bytes:
    """Return the datum of a physical `value`, or `raw`. Raises `ValueDoesNotFit`, `UsageError`."""
    if (value is None) == (raw is None):
        raise errors.usage_error("give a value or raw bytes", "нужно значение или исходные байты")
    if raw is None:
        assert value is not None
        return parameter.encode(value, interpretation)
    check_bytes(raw)
    if len(raw) != parameter.size:
        raise errors.ValueDoesNotFit(
            value=raw.hex().upper(),
            name=parameter.name,
            allowed=Text("it has {size}", "в нём {size}").filled(size=byte_count(parameter.size)),
        )
    return raw
