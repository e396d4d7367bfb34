"""The list in the unit that 64 sets and 63 reads (§3), and its parameters kept for later sessions.

The unit does not say which parameters its list has, so only a list that mikas has set can be read.
Their names are kept by the unit's passports. Every 64 drops the kept names of all units first: the
unit's own may be unknown at that moment, and a stale list would give wrong values. Another program
that sets a list of the same size can't be detected.
"""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

from mikas import commands as c
from mikas import errors, unkept
from mikas.catalog import Parameter
from mikas.client.gate import Change, Gate
from mikas.client.limits import unit_file
from mikas.client.parameters.data import RawDatum, distinct
from mikas.files import read_json
from mikas.i18n import Text, counted
from mikas.saving import save
from mikas.tester import Tester

Identity = tuple[int, tuple[str, ...]]  # version code and passports

_MOST_BYTES = 1 << 16  # of a kept list
_TOO_LONG = Text(
    "The list may be too long for this unit: name fewer parameters, or read without a list.",
    "Возможно, список для этого блока слишком длинен: назовите меньше параметров или читайте без "
    "списка.",
)
_OTHER_LIST = Text(
    "The unit has another list than the one expected: another program has set it, or the unit has "
    "lost it. Set the list again.",
    "В блоке не тот список, который ожидался: его задала другая программа или блок его потерял. "
    "Задайте список заново.",
)
_NOT_AS_NAMED = Text(
    "The unit's list has other parameters than those named. Name all of them in their order, or "
    "set the list again.",
    "В списке блока не те параметры, что названы. Назовите все по порядку или задайте список "
    "заново.",
)
_UNKEPT = Text(
    "The names of the unit's list can't be saved in {place} ({why}): the next session has to name "
    "its parameters to read it.",
    "Имена параметров списка блока не сохраняются в {place} ({why}): в следующий раз для чтения "
    "списка их придётся назвать.",
)
_PERHAPS_LOST = Text(
    "A unit may forget its list when its supply goes off: set the list again. "
    "Else the line is bad.",
    "При отключении питания блок может забыть список: задайте его заново. Иначе плохая связь.",
)


@dataclass(slots=True, eq=False)
class UnitList:
    """The unit's list. `current`: its parameters, as set in this session; () if unknown.

    The names of the last list are kept in a file of `folder`; None: they are not kept. `identify`
    returns version code and passports of the connected unit. A unit with empty passports can't be
    distinguished, so its list is not kept.
    """

    _tester: Tester
    _gate: Gate
    _folder: Path | None
    _identify: Callable[[], Identity]
    current: tuple[Parameter, ...] = field(init=False, default=())
    # The unit has one list for all threads.
    _lock: threading.RLock = field(init=False, default_factory=threading.RLock)

    @contextmanager
    def held(self) -> Iterator[None]:
        """Hold the list against other threads."""
        self._tester.check_free()  # the lock's holder may wait for a stream of this thread
        with self._lock:
            yield

    def is_set_to(self, wanted: tuple[Parameter, ...]) -> bool:
        """Whether the unit's list has the data of `wanted`, in their order; limits may differ."""
        current = self.current
        return current == wanted or (bool(current) and list_of(current) == list_of(wanted))

    def kept(self) -> tuple[str, ...]:
        """Return the names kept by an earlier session. Raises `NoList` if there are none.

        May read the passports, and raise their errors.
        """
        names: tuple[str, ...] = ()
        if self._files() and (file := self._file()):
            with suppress(OSError, ValueError, TypeError, LookupError):
                names = tuple(str(name) for name in read_json(file, _MOST_BYTES)["names"])
        if not names:
            raise errors.NoList
        return names

    def _keep(self, names: Sequence[str]) -> None:
        """Keep `names` of the connected unit."""
        if self._folder is None:
            return
        with unkept.saying_once(_UNKEPT, self._folder):
            if file := self._file():
                file.parent.mkdir(parents=True, exist_ok=True)
                save(file, json.dumps({"names": list(names)}))

    def forget(self) -> None:
        """Treat the unit's list as lost or changed; drop the lists kept of all units.

        Raises `UsageError` if one can't be dropped: stale names would be worse.
        """
        self.current = ()
        for file in self._files():
            with errors.naming_file(file):
                file.unlink(missing_ok=True)

    def _files(self) -> list[Path]:
        """Return what may be read as a list: a folder can't, and can't be deleted as a file."""
        found = self._folder.glob("*.json") if self._folder else ()
        return [file for file in found if file.is_symlink() or not file.is_dir()]

    def _file(self) -> Path | None:
        """Return the file of the connected unit; None if it can't be distinguished."""
        version_code, passports = self._identify()
        if self._folder is None or not any(passports):
            return None
        return unit_file(self._folder, version_code, passports)

    def set(self, wanted: tuple[Parameter, ...], *, keep: bool = False) -> None:
        """Set the list (64); `keep`: for later sessions too.

        Raises `NotConfirmed`, `WriteRefused`, `NotSupported`, a `LineError` or a `NoConnection`.
        """
        data = list_of(wanted)

        def act() -> None:
            self.forget()
            try:
                self._tester.request(c.WriteList(data))
            except errors.WriteRefused as error:
                error.advice = _TOO_LONG
                raise
            except (errors.NoResponse, errors.NotSupported) as error:
                if error.received:
                    raise
                # Perhaps only the answer was lost; setting the list twice has the same effect.
                self._tester.request(c.WriteList(data))
            self.current = wanted
            if keep:
                self._keep([p.name for p in wanted])

        with self.held():
            self._gate.make(_change(data, wanted), act, lambda _: None)

    def try_out(self, data: tuple[c.Datum, ...]) -> None:
        """Set the list to `data` once; it is not known afterwards. Raises as `set`."""

        def act() -> None:
            self.forget()
            self._tester.request(c.WriteList(data))

        with self.held():
            self._gate.make(_change(data), act, lambda _: None)

    def read(self, wanted: tuple[Parameter, ...], *, named: bool = False) -> dict[int, RawDatum]:
        """Read the list of `wanted` (63); return its data by code.

        `named`: by the user, so that another length says nothing about the list set by mikas.
        Raises `ListLost` for a refusal, `NotSupported` if the unit does not know 63, `WrongLength`
        for another list, `NoResponse`.
        """
        data = list_of(wanted)
        try:
            values, reply = self._tester.exchange(c.ReadList(data))
        except errors.NotSupported as error:
            never_read = bool(self.current) and not self._tester.has_answered(c.ReadList.CODES[0])
            self.forget()
            if never_read:
                raise
            raise errors.ListLost(
                request=error.request, received=error.received, time=error.time
            ) from error
        except errors.WrongLength as error:
            if not named:
                self.forget()
            error.advice = _NOT_AS_NAMED if named else _OTHER_LIST
            raise
        except errors.NoResponse as error:
            self.forget()
            error.advice = _PERHAPS_LOST
            raise
        except errors.NoConnection:
            self.current = ()
            raise
        return {d.code: RawDatum(raw, reply.began) for d, raw in zip(data, values, strict=True)}


def _change(data: tuple[c.Datum, ...], wanted: tuple[Parameter, ...] = ()) -> Change:
    parameters = counted(
        len(wanted or set(data)),
        ("parameter", "parameters"),
        ("параметр", "параметра", "параметров"),
    )
    what = Text(
        f"set the unit's list to {parameters.en}",
        f"задать список блока: {parameters.ru}",
    )
    names = ", ".join(parameter.name for parameter in wanted)
    new = Text(names, names) if names else None
    return Change.by(c.WriteList, what, after=bytes(d.code for d in data), new=new)


def list_of(parameters: Sequence[Parameter]) -> tuple[c.Datum, ...]:
    """Return the list for 64. A single byte is listed twice: a unit that has lost its list may
    answer 63 with 01 (D10), which must not look like a datum.
    """
    data = distinct(parameters)
    return data * 2 if data == ((data[0].code, 1),) else data
