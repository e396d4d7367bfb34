"""Parameters by name: read, watched, listed, streamed, written (§3 rows 60–64, 71, 7F–83; §4)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from mikas import commands as c
from mikas.catalog import Catalog, Parameter
from mikas.client.data import DataReader, Got, refused
from mikas.client.gate import Change, Gate, hexed
from mikas.client.reading import Reading, decode
from mikas.errors import (
    NotSupported,
    ReadBackDiffers,
    UsageError,
    ValueDoesNotFit,
)
from mikas.language import Text
from mikas.tester import StreamItem, Tester

if TYPE_CHECKING:
    from mikas.tester import Stream


@dataclass(frozen=True, slots=True)
class WrittenParameter:
    """What a parameter write did. `before` and `after`: None where it can't be read."""

    name: str
    before: Reading | None
    after: Reading | None


class Parameters:
    """Names on one side, codes and bytes on the other."""

    def __init__(
        self, tester: Tester, catalog: Catalog, gate: Gate, data: DataReader, reading: str
    ) -> None:
        self._tester = tester
        self._catalog = catalog
        self._gate = gate
        self._data = data
        self._reading = reading
        self._listed: tuple[Parameter, ...] = ()

    def named(self, names: Sequence[str]) -> tuple[Parameter, ...]:
        """The parameters of these names, all of the catalog if there are none."""
        return tuple(map(self._catalog.parameter, names)) or self._catalog.parameters

    def read(self, names: Sequence[str], *, method: str = "batch") -> dict[str, Reading]:
        """One reading each. Raises `NotSupported` for a named one that the unit does not know.

        With no names: all that the unit knows, the others are left out.
        """
        wanted = self.named(names)
        got = self.fetch(wanted, method)
        if names:
            for parameter in wanted:
                if parameter.code not in got:
                    raise refused(parameter.name, parameter.code)
        return self.readings(wanted, got)

    def fetch(self, wanted: Sequence[Parameter], method: str) -> dict[int, Got]:
        """The data of `wanted` by code, every code asked once."""
        data = distinct(wanted)
        return self._data.single(data) if method == "single" else self._data.batch(data)

    def readings(self, wanted: Sequence[Parameter], got: dict[int, Got]) -> dict[str, Reading]:
        """What `got` means for each of `wanted` that it has."""
        return {
            p.name: decode(p, got[p.code].raw, got[p.code].time, self._reading)
            for p in wanted
            if p.code in got
        }

    # Lists, 63 and 64

    def set_list(self, names: Sequence[str]) -> tuple[str, ...]:
        """Sets the unit's list (64), which `read_list` then reads; a power cycle forgets it."""
        wanted = self.named(names)
        data = distinct(wanted)
        change = Change(
            what=Text(
                f"set the unit's list to {len(data)} code(s)", f"задать список кодов: {len(data)}"
            ),
            safety=c.WriteList.SAFETY,
            command=c.WriteList.SOURCE_NAME,
            after=hexed(bytes(d.code for d in data)),
        )

        def act() -> None:
            self._listed = ()
            self._tester.request(c.WriteList(data))

        self._gate.make(change, act, lambda _: None)
        self._listed = wanted
        return tuple(p.name for p in wanted)

    def read_list(self) -> dict[str, Reading]:
        """One reading of each parameter in the list that this session set (63)."""
        if not self._listed:
            raise UsageError(problem=Text("set_list() comes first", "сначала нужен set_list()"))
        data = distinct(self._listed)
        values, reply = self._tester.exchange(c.ReadList(data))
        got = {d.code: Got(raw, reply.began) for d, raw in zip(data, values, strict=True)}
        return self.readings(self._listed, got)

    # Streams, 71 and 7F … 83

    @contextmanager
    def stream(
        self, names: Sequence[str], *, stroke: int | None = None
    ) -> Iterator[Iterator[dict[str, Reading]]]:
        """The readings that the unit sends by itself, until the `with` is left (D12).

        `stroke`: 0 … 4 for one response an engine cycle (D15); None for the cyclic stream.
        """
        wanted = self.named(names)
        with self.raw_stream(wanted, stroke) as stream:
            yield (self.of_item(wanted, item) for item in stream)

    def raw_stream(self, wanted: Sequence[Parameter], stroke: int | None) -> Stream:
        """The tester's own stream of `wanted`, to be closed."""
        data = distinct(wanted)
        command = c.StreamCyclic(data) if stroke is None else c.StreamAtStroke(data, stroke)
        return self._tester.stream(command)

    def of_item(self, wanted: Sequence[Parameter], item: StreamItem) -> dict[str, Reading]:
        """The readings of one streamed response."""
        data = distinct(wanted)
        got = {d.code: Got(raw, item.time) for d, raw in zip(data, item.data, strict=True)}
        return self.readings(wanted, got)

    # Writing, 62

    def write(self, name: str, value: float | None, raw: bytes | None) -> WrittenParameter:
        """Writes a physical `value`, or the `raw` datum, and reads it back.

        Raises `ValueDoesNotFit`, `NotConfirmed`, `WriteRefused`, `ReadBackDiffers`.
        """
        parameter = self._catalog.parameter(name)
        data = self._datum(parameter, value, raw)
        before = self._one(parameter)
        change = Change(
            what=Text(f"write parameter {parameter.name}", f"записать параметр {parameter.name}"),
            safety=c.WriteParameter.SAFETY,
            command=c.WriteParameter.SOURCE_NAME,
            before=hexed(before.raw) if before else None,
            after=hexed(data),
        )

        def act() -> WrittenParameter:
            self._tester.request(c.WriteParameter(parameter.code, data))
            after = self._one(parameter)
            if after and after.raw != data:
                raise ReadBackDiffers(name=parameter.name, wanted=hexed(data), got=hexed(after.raw))
            return WrittenParameter(parameter.name, before, after)

        return self._gate.make(change, act, lambda w: hexed(w.after.raw) if w.after else None)

    def _datum(self, parameter: Parameter, value: float | None, raw: bytes | None) -> bytes:
        if (value is None) == (raw is None):
            raise UsageError(
                problem=Text("give a value or raw bytes", "нужно значение или исходные байты")
            )
        if raw is None:
            assert value is not None
            return parameter.encode(value, self._reading)
        if len(raw) != parameter.size:
            raise ValueDoesNotFit(
                value=raw.hex().upper(),
                name=parameter.name,
                allowed=Text(f"it has {parameter.size} byte(s)", f"байтов: {parameter.size}"),
            )
        return raw

    def _one(self, parameter: Parameter) -> Reading | None:
        try:
            got = self._data.batch([c.Datum(parameter.code, parameter.size)])
        except NotSupported:
            return None
        return self.readings([parameter], got).get(parameter.name)


def distinct(parameters: Sequence[Parameter]) -> tuple[c.Datum, ...]:
    """Their codes, each once: RXX, BITPOW and RDET are one byte (§5)."""
    return tuple(dict.fromkeys(c.Datum(p.code, p.size) for p in parameters))
