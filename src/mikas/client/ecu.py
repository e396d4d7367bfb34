"""The public object: one ECU with all that can be read from it or changed in it.

All errors are of `mikas.errors`. Reading changes nothing; every change passes the gate. Several
threads may use one `Ecu`.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Self

from mikas import commands as c
from mikas.catalog import Catalog, Fault, Model
from mikas.catalog.model import check_interpretation
from mikas.cleaning import public_port
from mikas.client.erasing import Erased, erase
from mikas.client.gate import Change, Confirm, Gate, journal_hex
from mikas.client.identity import Info, Passport, PassportReader, count_parameters
from mikas.client.limits import Limits, LimitsCache, LimitsStore, MethodTiming
from mikas.client.memory.spaces import Memory
from mikas.client.parameters.data import COMMON, DataReader
from mikas.client.parameters.derived import DerivedValue
from mikas.client.parameters.parameters import Parameters, WrittenParameter
from mikas.client.parameters.polling import FixedMethod, named_method
from mikas.client.parameters.readings import Reading, Sample
from mikas.client.parameters.unit_list import UnitList
from mikas.client.parameters.watching import Watcher
from mikas.client.recorded import EcuRecording, recorded
from mikas.client.scanning import Scan, ScannedCode
from mikas.client.support import Support, try_commands
from mikas.commands.base import check_bytes
from mikas.errors import (
    CaptureError,
    EcuRefused,
    LineError,
    UnknownParameter,
    usage_error,
)
from mikas.i18n import Text
from mikas.tester import Tester

_SPEED = "FREQ"


class Ecu:
    """A connected unit, created by `connect`. Close it, or use it in a `with` statement.

    `timeout` of a method: the seconds that the whole call may last; `DeadlinePassed` then ends it
    between two requests. None: as long as it takes. The time-out of one request is `connect`'s.

    Changes pass the gate: `connect(confirm=…)` is asked before each, and answers True or False.
    Without `confirm` they are made at once: `write_parameter`, `erase_faults`, `set_list`, writes
    to RAM, XRAM and SFR, and `raw` bodies of such commands or of unknown ones. Refused without it,
    by `NotConfirmed`, are those that may leave the unit unable to run: writes to CODE, `goto`, and
    `raw` bodies of either. Reading asks only where it sets the list: `watch` by method list.

    The sampler works with its parts: `tester`, `parameters`, `passports`, `limits_cache`.
    """

    def __init__(
        self,
        tester: Tester,
        catalog: Catalog,
        *,
        interpretation: str = "corrected",
        confirm: Confirm | None = None,
        journal: Path | None = None,
        store: LimitsStore | None = None,
        lists: Path | None = None,
    ) -> None:
        check_interpretation(interpretation)
        self.tester = tester
        """The exchange of single requests, with its statistics."""
        self.catalog: Catalog = catalog
        """The definitions that name and decode."""
        self.limits_cache: LimitsCache = LimitsCache(store, self._identify, tester.pauses)
        """The learnt limits of this unit."""
        self.passports: PassportReader = PassportReader(tester, on_other=self.limits_cache.reset)
        """The reader of its passports."""
        self._gate = Gate(tester, self._whose, confirm, journal)
        data = DataReader(tester, self.limits_cache)
        self._list = UnitList(tester, self._gate, lists, self._identify)
        self.parameters: Parameters = Parameters(
            tester, catalog, interpretation, self._gate, data, self._list
        )
        """The reader of its parameters."""
        self.memory: Memory = Memory(tester, self._gate, self.limits_cache)
        """RAM, XRAM, CODE and SFR: `ecu.memory.code.read_block(0x8000, 256)`."""

    def use_catalog(self, catalog: Catalog) -> None:
        """Name and decode by another catalog from here on."""
        self.catalog = catalog
        self.parameters.catalog = catalog

    @property
    def version_code(self) -> int:
        """The unit's answer to 01 when it was connected."""
        assert self.tester.version_code is not None
        return self.tester.version_code

    @property
    def model(self) -> Model:
        """The model of this version code, perhaps an unknown one."""
        return self.catalog.model(self.version_code)

    # Identity

    def info(self, *, timeout: float | None = None) -> Info:
        """Read model, passports, number of parameters, echo and learnt limits: nine requests."""
        with self.tester.within(timeout):
            return Info(
                model=self.model,
                version_code=self.version_code,
                passport=self.passport(),
                parameter_count=count_parameters(self.tester),
                echo=self.tester.line.echo,
                limits=self.limits(),
                pause=self.tester.line.pause,
            )

    def passport(self, *, again: bool = False, timeout: float | None = None) -> Passport:
        """Read the program's and the data's passport (51–58), once a session.

        `again`: read once more, for another unit may answer after a pause. A piece that was read
        before and is missing now was lost on the line; the earlier value stays.
        """
        if not again and self.passports.latest is not None:
            return self.passports.latest
        with self.tester.within(timeout):
            self.passports.restart()
            return self.passports.read()

    def supported(self) -> Iterator[Support]:
        """Try every command once that changes nothing but the unit's list (64); yield the results.

        The streams by strokes are tried with the engine turning only. Takes a second for each
        command without a response, and two for each stream.
        """
        return try_commands(self.parameters)

    # Parameters

    def read(self, *names: str, timeout: float | None = None) -> dict[str, Reading | DerivedValue]:
        """Read each named channel once; without names, all parameters that the unit knows.

        A raw code is written `0x1A`, or `0x3F:2`. Of a derived channel (`FUEL_FLOW`) the parameters
        that it needs are read, in as few requests as possible; where its formula has no result,
        `DerivedValue.has_value` is false. Raises `UnknownParameter`, `NeedsSamples` for a channel
        that is added up over time (`FUEL_USED`), `NotSupported` if the unit does not know a named
        parameter or one that is needed, or knows none, `LineError`, `NoConnection`.
        """
        with self.tester.within(timeout):
            return self.parameters.read(names)

    def watch(
        self,
        *names: str,
        method: FixedMethod = "batch",
        rate: float | None = None,
        count: int | None = None,
    ) -> Generator[Sample, None, None]:
        """Yield `count` samples, or without end, at `rate` a second or as fast as the line allows.

        A failed cycle is a sample with `gap`; parameters unknown to the unit are missing. Raises
        `LinkLost`, `UnknownParameter`, and `EcuRefused` if the unit refuses the method or every
        parameter.

        batch: few requests (61), which change nothing in the unit and leave the line free between
        cycles; single: one request a parameter; list: 64 and 63, which change the unit's list;
        stream: 71; stroke0 … stroke4: 7F … 83. A stream occupies the line until the generator is
        closed or has yielded `count` samples. `mikas.session` finds the fastest that works, waits
        for a lost adapter and computes derived channels.
        """
        return Watcher(self.parameters, names, named_method(method), rate).samples(count)

    @contextmanager
    def stream(
        self, *names: str, stroke: int | None = None
    ) -> Iterator[Iterator[dict[str, Reading]]]:
        """Stream readings until the `with` ends (71, 7F–83, D12): `with ecu.stream("FREQ") as …`.

        `stroke`: 0 … 4 for one response an engine cycle (D15).
        """
        wanted = self.parameters.wanted(self.parameters.named(names))
        with self.parameters.stream(wanted, stroke) as stream:
            yield (wanted.of_item(item) for item in stream)

    def set_list(self, *names: str, timeout: float | None = None) -> tuple[str, ...]:
        """Set the list that `read_list` reads (64); return the names in it.

        The names are kept for later sessions with this unit. Raises `UnknownParameter`,
        `NotConfirmed`, `WriteRefused`, `NotSupported`.
        """
        wanted = self.parameters.named(names)
        with self.tester.within(timeout):
            self._list.set(wanted, keep=True)
        return tuple(p.name for p in wanted)

    def read_list(self, *names: str, timeout: float | None = None) -> dict[str, Reading]:
        """Read each parameter of the list once (63): of `names`, or as mikas has set it last.

        The unit does not say which parameters its list has; only the response's length is checked.
        Raises `NoList` without a `set_list`, also after a failure, `ListLost` for a refusal (the
        unit has lost its list), `WrongLength` for another list, `NoResponse`.
        """
        parameters, unit_list = self.parameters, self._list
        with self.tester.within(timeout), unit_list.held():
            if names:
                listed = parameters.named(names)
            else:
                listed = unit_list.current or parameters.named(unit_list.kept())
            data = unit_list.read(listed, named=bool(names))
            return parameters.wanted(listed).readings(data)

    def forget_list(self) -> None:
        """Treat the unit's list as lost, as after a power cycle: it has to be set again."""
        self._list.forget()

    def scan(self) -> Generator[ScannedCode, None, None]:
        """Request every code 00–FF by 61; yield the answer to each, the catalog's codes first.

        A code whose answer was unclear is requested, and comes, once more at the end. A silent code
        takes two seconds. Changes nothing. Raises `NoConnection`, `SyncLost`, `LineNotQuiet`.
        """
        known = [*(datum.code for datum in COMMON), *(code for code, _ in self.catalog.codes)]
        return Scan(self.tester, known).codes()

    def write_parameter(
        self,
        name: str,
        value: float | None = None,
        *,
        raw: bytes | None = None,
        timeout: float | None = None,
    ) -> WrittenParameter:
        """Write a physical `value`, or the `raw` datum, and read it back (62).

        Raises `ValueDoesNotFit`, `NotConfirmed`, `WriteRefused`, `ReadBackDiffers`.
        """
        with self.tester.within(timeout):
            return self.parameters.write(name, value, raw)

    # Faults

    def faults(self, *, timeout: float | None = None) -> tuple[Fault, ...]:
        """Read the stored faults in the unit's order; one unknown to the catalog has no text."""
        with self.tester.within(timeout):
            return tuple(self.catalog.fault(code) for code in self.tester.request(c.ReadFaults()))

    def engine_speed(self, *, timeout: float | None = None) -> float | None:
        """Read the engine's speed in rpm; None: the unit does not give it."""
        try:
            return float(self.read(_SPEED, timeout=timeout)[_SPEED].value)
        except (EcuRefused, LineError, UnknownParameter):
            return None

    def erase_faults(self, *, timeout: float | None = None) -> Erased:
        """Erase the faults by two writes (§3). Raises `NotConfirmed`, `WriteRefused`.

        Where changes are confirmed, the confirmation says that the engine is running.
        """
        with self.tester.within(timeout):
            return erase(self.tester, self._gate, self.faults, self.engine_speed)

    def goto(self, address: int, *, timeout: float | None = None) -> bytes:
        """Make the ECU jump to `address` (41), the most dangerous command; return its response.

        The expected silence (D9) is returned as empty bytes.
        """
        command = c.GoTo(address)
        what = Text(f"jump to {address:04X}", f"перейти на {address:04X}")
        change = Change.by(command, what, after=command.body(), address=address)
        with self.tester.within(timeout):
            return self._gate.make(change, lambda: self.tester.raw(command.body()) or b"", bytes)

    def raw(self, body: bytes, *, timeout: float | None = None) -> bytes | None:
        """Send any request body; return the response's body, None for silence.

        Unless the command is known to be harmless, it passes the gate. Raises `NotConfirmed`,
        `NoEcho`, or a `LineError` for a damaged or doubled response.
        """
        check_bytes(body)
        if not body:
            raise usage_error("there is nothing to send", "нечего посылать")
        with self.tester.within(timeout):
            return self._raw(bytes(body))

    def _raw(self, body: bytes) -> bytes | None:
        command = c.COMMANDS_BY_CODE.get(body[0])
        if command and command.SAFETY is c.Safety.READ:
            return self.tester.raw(body)
        change = Change(
            what=Text(f"send {journal_hex(body)}", f"послать {journal_hex(body)}"),
            safety=command.SAFETY if command else c.Safety.LASTING,
            command=command.SOURCE_NAME if command else "?",
            after=journal_hex(body),
        )

        def act() -> bytes | None:
            if command is c.WriteList:
                self.forget_list()
            return self.tester.raw(body)

        return self._gate.make(change, act, lambda response: response)

    def record(
        self,
        path: str | os.PathLike[str],
        *,
        on_failure: Callable[[CaptureError], object] | None = None,
    ) -> EcuRecording:
        """Record every exchange to `path` (.pcapng): `with ecu.record("drive.pcapng"): …`.

        The file is as those of `mikas log`, with the unit's identity: its passports are read if
        they are not known yet. It ends with the `with` statement or by `close`. `on_failure` gets
        the error of a full disk, and the requests go on unrecorded; without it the error is raised.
        Set a list (64) while it is recorded: a later `read_list` can't be decoded without.
        Raises `CaptureError` for a file that exists or can't be made.
        """
        return recorded(self, path, on_failure)

    def limits(self) -> Limits:
        """Return a copy of the learnt limits. May read the unit's passport and raise its errors."""
        return self.limits_cache.limits().copy()

    def keep_timings(self, adapter: str, timings: Mapping[str, MethodTiming]) -> None:
        """Save the speed of each sampling method with this kind of adapter."""
        self.limits_cache.keep_timings(adapter, timings)

    def forget_limits(self) -> None:
        """Delete the learnt limits of this unit, the saved ones too."""
        self.limits_cache.forget()

    def _identify(self) -> tuple[int, tuple[str, ...]]:
        return self.version_code, self.passport().pieces

    def _whose(self) -> dict[str, object]:
        return {"port": public_port(self.tester.link.url), "model": self.model.text.en}

    def __repr__(self) -> str:
        return f"<Ecu {self.model.text.en} on {public_port(self.tester.link.url)}>"

    def close(self) -> None:
        """End a running stream and close the port; a second call does nothing."""
        self.tester.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
