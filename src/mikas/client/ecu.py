"""The public object: one ECU, everything that can be read from it or changed in it.

Each method says what it raises; all of it comes from `mikas.errors`. Reading changes nothing; every
change goes through the gate. Several threads may use one `Ecu`.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from types import TracebackType
from typing import Self

from mikas import commands as c
from mikas.catalog import Catalog, Fault, Model, Parameter
from mikas.catalog.model import check_interpretation
from mikas.client.data import DataReader
from mikas.client.gate import Change, Confirm, Gate, Journal, hex_or_none
from mikas.client.identity import (
    Info,
    Passport,
    Support,
    count_parameters,
    read_passport,
    try_commands,
)
from mikas.client.limits import Limits, LimitsCache, LimitsStore, MethodTiming
from mikas.client.memory import Memory
from mikas.client.parameters import Parameters, Reading, Sample, WrittenParameter
from mikas.client.polling import (
    FixedMethod,
    Method,
    Poller,
    Watcher,
    create_poller,
    fixed_method,
)
from mikas.errors import NoResponse, NotSupported, UsageError
from mikas.i18n import Text, counted
from mikas.tester import Tester


@dataclass(frozen=True, slots=True)
class Erased:
    """The faults that were stored before an erase, and those stored after it."""

    before: tuple[Fault, ...]
    after: tuple[Fault, ...]


def erasing(count: int) -> Text:
    """Return the text for erasing `count` faults."""
    faults = counted(count, ("stored fault", "stored faults"), ("ошибку", "ошибки", "ошибок"))
    return Text("erase {faults}", "стереть {faults}").filled(faults=faults)


class Ecu:
    """A connected unit; made by `connect`. Close it, or use it with `with`."""

    def __init__(
        self,
        tester: Tester,
        catalog: Catalog,
        *,
        interpretation: str = "corrected",
        confirm: Confirm | None = None,
        journal: Journal | None = None,
        store: LimitsStore | None = None,
    ) -> None:
        check_interpretation(interpretation)
        self.tester = tester
        self.catalog = catalog
        self._passport: Passport | None = None
        self._limits = LimitsCache(store, lambda: self.version_code, lambda: self.passport().pieces)
        self._gate = Gate(
            confirm=confirm,
            journal=journal,
            clock=tester.link.now,
            whose=self._whose,
            ready=tester.check_free,
        )
        data = DataReader(tester, self._limits.limits, self._limits.keep)
        self._parameters = Parameters(tester, catalog, self._gate, data, interpretation)
        self.memory = Memory(tester, self._gate, self._limits.limits, self._limits.keep)

    @property
    def version_code(self) -> int:
        """The unit's answer to 01 at connect."""
        assert self.tester.version_code is not None
        return self.tester.version_code

    @property
    def model(self) -> Model:
        """The model of this version code; it may be an unknown one."""
        return self.catalog.model(self.version_code)

    # Identity

    def info(self) -> Info:
        """Model, passports, number of parameters, echo, learnt limits: nine requests."""
        return Info(
            model=self.model,
            version_code=self.version_code,
            passport=self.passport(),
            parameter_count=count_parameters(self.tester),
            echo=self.tester.echoes,
            limits=self.limits(),
        )

    def passport(self, *, again: bool = False) -> Passport:
        """Read the program's and the data's passport (51–58), once a session.

        `again`: read once more; after a pause another unit may answer. A piece that was read before
        and is missing now was lost on the line, and stays.
        """
        if again or self._passport is None:
            before, found = self._passport, read_passport(self.tester)
            if before is not None and before.may_be(found):
                found = found.filled_from(before)
            self._passport = found
            if before is not None and before != found:
                self._limits.reset()
        return self._passport

    def supported(self) -> Iterator[Support]:
        """Try every harmless command once and yield whether the unit knows it (D10)."""
        return try_commands(self.tester)

    # Parameters

    def read(self, *names: str) -> dict[str, Reading]:
        """Read each named parameter once; with no names, all that the unit knows.

        A raw code is written `0x1A`, or `0x3F:2`. Raises `UnknownParameter`, `NotSupported` for a
        named one that the unit does not know, or if it knows none, a `LineError`, `NoConnection`.
        """
        return self._parameters.read(names)

    def watch(
        self,
        *names: str,
        method: Method = "auto",
        rate: float | None = None,
        count: int | None = None,
    ) -> Generator[Sample, None, None]:
        """Yield `count` samples, or without end, as fast as the wire allows or `rate` a second.

        A cycle that failed is a sample with `gap`; a parameter that the unit does not know is
        missing. Raises `LinkLost`, `UnknownParameter`, and `EcuRefused` if it refuses the method
        or every parameter.

        auto, batch: as few requests (61) as the unit takes, which changes nothing in it and leaves
        the line free in between; single: one a parameter; list: by 64 and 63, which changes the
        unit's list; stream: 71; stroke0 … stroke4: 7F … 83. A stream keeps the line to itself until
        what is returned is closed, or has yielded `count` samples. `mikas.sampling` finds out which
        method is the fastest on a unit.
        """
        fixed = fixed_method(method) or "batch"
        return Watcher(self.tester, self._parameters, names, fixed, rate).samples(count)

    def stream(
        self, *names: str, stroke: int | None = None
    ) -> AbstractContextManager[Iterator[dict[str, Reading]]]:
        """`with ecu.stream("FREQ") as readings:` — what the unit sends by itself (71, 7F–83).

        `stroke`: 0 … 4 for one response an engine cycle (D15). Leaving the `with` ends it (D12).
        """
        return self._parameters.stream(names, stroke=stroke)

    def set_list(self, *names: str) -> tuple[str, ...]:
        """Set the list that `read_list` reads (64); return the names in it.

        Raises `UnknownParameter`, `NotConfirmed`, `WriteRefused`, `NotSupported`.
        """
        return self._parameters.set_list(names)

    def read_list(self) -> dict[str, Reading]:
        """Read each parameter of the list once (63); `set_list` sets it.

        Raises `UsageError` without a list, and after silence, for then the unit may have lost it.
        """
        return self._parameters.read_list()

    def forget_list(self) -> None:
        """Take the unit's list for lost, as after its supply was off: it has to be set again."""
        self._parameters.forget_list()

    def write_parameter(
        self, name: str, value: float | None = None, *, raw: bytes | None = None
    ) -> WrittenParameter:
        """Write a physical `value`, or the `raw` datum, and read it back (62).

        Raises `ValueDoesNotFit`, `NotConfirmed`, `WriteRefused`, `ReadBackDiffers`.
        """
        return self._parameters.write(name, value, raw)

    # Faults

    def faults(self) -> tuple[Fault, ...]:
        """Read the stored faults, in the unit's order; one that the catalog lacks has no text."""
        return tuple(self.catalog.fault(code) for code in self.tester.request(c.ReadFaults()))

    def erase_faults(self) -> Erased:
        """Erase the faults (two writes, §3), read again. Raises `NotConfirmed`, `WriteRefused`."""
        before = self.faults()
        change = Change(
            what=erasing(len(before)),
            safety=c.WriteParameter.SAFETY,
            command=c.WriteParameter.SOURCE_NAME,
            before=hex_or_none(bytes(fault.code for fault in before)),
            after="",
        )

        def act() -> Erased:
            try:
                self.tester.in_a_row(*c.ERASE_FAULTS)
            except (NoResponse, NotSupported) as error:
                if error.received:
                    raise
                # Only an answer may be lost, and erasing twice does what erasing once does.
                self.tester.in_a_row(*c.ERASE_FAULTS)
            return Erased(before, self.faults())

        return self._gate.make(
            change, act, lambda erased: hex_or_none(bytes(fault.code for fault in erased.after))
        )

    # The rest

    def goto(self, address: int) -> bytes:
        """Make the ECU jump to `address` (41), the most dangerous command.

        Returns the body of a response, empty for the expected silence (D9).
        """
        command = c.GoTo(address)
        change = Change(
            what=Text(f"jump to {address:04X}", f"перейти на {address:04X}"),
            safety=command.SAFETY,
            command=command.SOURCE_NAME,
            after=hex_or_none(command.body()),
        )
        return self._gate.make(change, lambda: self.tester.raw(command.body()) or b"", hex_or_none)

    def raw(self, body: bytes) -> bytes | None:
        """Send any request body; return the response's body, None for silence.

        A command that is not known to be harmless passes the gate. Raises `NotConfirmed`, `NoEcho`,
        or a `LineError` for a damaged or doubled response.
        """
        if not body:
            raise UsageError(problem=Text("there is nothing to send", "нечего посылать"))
        command = c.COMMANDS_BY_CODE.get(body[0])
        if command and command.SAFETY is c.Safety.READ:
            return self.tester.raw(body)
        change = Change(
            what=Text(f"send {hex_or_none(body)}", f"послать {hex_or_none(body)}"),
            safety=command.SAFETY if command else c.Safety.LASTING,
            command=command.SOURCE_NAME if command else "?",
            after=hex_or_none(body),
        )

        def act() -> bytes | None:
            if command is c.WriteList:
                self.forget_list()
            return self.tester.raw(body)

        return self._gate.make(change, act, hex_or_none)

    # What was learnt

    def limits(self) -> Limits:
        """Return a copy of what was learnt of this unit.

        May read the unit's passport, and raises what that raises.
        """
        return self._limits.limits().copy()

    def keep_timings(self, adapter: str, timings: Mapping[str, MethodTiming]) -> None:
        """Save how fast each sampling method is with this kind of adapter."""
        self._limits.keep_timings(adapter, timings)

    def forget_limits(self) -> None:
        """Forget all that was learnt of this unit, the saved limits too; it is learnt again."""
        self._limits.forget()

    def _whose(self) -> dict[str, object]:
        return {"port": self.tester.link.url, "model": self.model.text.en}

    def close(self) -> None:
        """End a running stream and close the port. A second call does nothing."""
        self.tester.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()


def poller_of(
    ecu: Ecu, method: FixedMethod, streamed: Sequence[Parameter] = (), *, again: bool = False
) -> Poller:
    """Create a poller of `ecu` by `method`; `streamed`: what a stream sends.

    `again`: ask once more for parameters that the unit has refused before.
    """
    parameters = ecu._parameters  # noqa: SLF001  (what samples an ECU belongs to it as its methods)
    return create_poller(ecu.tester, parameters, method, streamed, again=again)
