"""Which commands the unit knows: a trial of each that changes nothing, or only the list (§3, D10).

64 replaces the unit's list, so that 63 can be tried: the list that mikas has set is set again, one
that another program has set is lost.
The streams by strokes are tried only with the engine turning (D15); every stream is ended (D12).
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any

from mikas import commands as c
from mikas.client.identity import count_parameters
from mikas.client.parameters.data import COMMON
from mikas.client.parameters.parameters import Parameters
from mikas.errors import EcuRefused, LineError, NoResponse, NotConfirmed, NotSupported, UsageError
from mikas.i18n import Text

_STANDING = Text("the engine is not turning", "двигатель не вращается")
_SPEED_UNKNOWN = Text(
    "no response, and this unit does not report the engine speed",
    "ответа нет, а частоту вращения этот блок не сообщает",
)
_NO_LIST = Text("no list could be set (64)", "задать список (64) не удалось")
_CYCLES = 4  # of the engine without a response, after which a stream by strokes is not known


@dataclass(frozen=True, slots=True)
class Support:
    """Whether the unit knows the command of this code. `known` None: not tried, or uncertain.

    `reason`: why not tried or uncertain, unless the command changes more than the unit's list.
    """

    command: type[c.Command[Any]]
    """The command's class in `mikas.commands`."""
    code: int
    """Its code."""
    known: bool | None
    """Whether the unit knows it; None: not tried, or uncertain."""
    reason: Text | None = None

    @property
    def name(self) -> str:
        """The source's name and the code."""
        return self.command.name_by(self.code).en

    @property
    def title(self) -> Text:
        """The command's title, of a stream by strokes with the stroke."""
        title = self.command.TITLE
        if self.command is not c.StreamAtStroke:
            return title
        stroke = self.command.CODES.index(self.code)
        return Text(f"{title.en} ({stroke})", f"{title.ru} ({stroke})")


def each_command() -> Iterator[tuple[type[c.Command[Any]], tuple[int, ...]]]:
    """Yield every command with the codes that one trial decides: each stroke has its own."""
    for command in c.ALL_COMMANDS:
        if command is c.StreamAtStroke:
            yield from ((command, (code,)) for code in command.CODES)
        else:
            yield command, command.CODES


def try_commands(
    parameters: Parameters, leaving_out: Container[int] = frozenset()
) -> Iterator[Support]:
    """Try every command of §3 that changes nothing but the unit's list; yield the results.

    `leaving_out`: the codes of commands that are not tried. Raises `NoConnection` if the unit is
    gone.
    """
    trials = _Trials(parameters)
    for command, (code, *_) in sorted(each_command(), key=_after_its_list):
        known, reason = (None, None) if code in leaving_out else trials.result(code)
        yield Support(command, code, known, reason)


def _after_its_list(each: tuple[type[c.Command[Any]], tuple[int, ...]]) -> int:
    """Sort 63 behind 64, which sets its list."""
    command, codes = each
    return c.WriteList.CODES[0] + 1 if command is c.ReadList else codes[0]


class _Uncertain(Exception):
    """The trial gave no result, for this reason."""

    def __init__(self, reason: Text) -> None:
        self.reason = reason
        super().__init__(reason.en)


class _Trials:
    """A function for each code; it returns None, or raises, if the unit does not know the code."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self._tester = parameters.tester
        self._datum = COMMON[0]  # replaced by the first that the unit knows
        self._list: c.ReadList | None = None  # that 64 has set
        self._reports_speed = True
        harmless: tuple[c.Command[Any], ...] = (
            c.Availability(), c.ReadFaults(), c.ReadRamByte(0), c.ReadXramByte(0),
            c.ReadCodeByte(0), c.ReadRamBlock(0, 2), c.ReadXramBlock(0, 2), c.ReadCodeBlock(0, 2),
            c.ReadSfr(0x81), c.ReadProgramPassport(1), c.ReadDataPassport(1),
        )  # fmt: skip
        self._of: dict[int, Callable[[], object]] = {
            command.code: partial(self._tester.request, command) for command in harmless
        }
        self._of |= {
            0x60: partial(count_parameters, self._tester),
            0x61: self._read_parameters,
            0x63: self._read_list,
            0x64: self._set_list,
            0x71: self._stream,
        }
        for stroke, code in enumerate(c.StreamAtStroke.CODES):
            self._of[code] = partial(self._stream_at, stroke)

    def result(self, code: int) -> tuple[bool | None, Text | None]:
        """Try `code`; return whether it is known, and the reason if that is uncertain."""
        if code not in self._of:
            return None, None
        try:
            return self._of[code]() is not None, None
        except (EcuRefused, NoResponse):
            return False, None
        except _Uncertain as error:
            return None, error.reason
        except LineError:
            return None, None

    def _read_parameters(self) -> object:
        for datum in COMMON:
            for wanted in _lists_of(datum):
                with suppress(EcuRefused, NoResponse):
                    if self._tester.request(c.ReadParameters(wanted)) != (b"\x01",):
                        self._datum = datum
                        return True
        return None

    def _set_list(self) -> object:
        for wanted in _lists_of(self._datum):
            try:
                self._list = self._parameters.try_list(wanted)
                return True
            except (EcuRefused, NoResponse):
                pass
            except (NotConfirmed, UsageError) as error:  # no journal, or no folder for lists
                raise _Uncertain(error.reason) from error
        return None

    def _read_list(self) -> object:
        if self._list is None:
            raise _Uncertain(_NO_LIST)
        data = self._tester.request(self._list)
        return None if data == (b"\x01",) else data

    def _stream(self) -> object:
        with self._tester.stream(c.StreamCyclic((self._datum, self._datum))) as responses:
            return next(responses)

    def _stream_at(self, stroke: int) -> object:
        rpm = self._rpm()
        if rpm == 0:
            raise _Uncertain(_STANDING)
        command = c.StreamAtStroke((self._datum, self._datum), stroke)
        with self._tester.stream(command) as responses:
            seconds = responses.silence
            if rpm:  # a cycle is two turns
                cycles = max(self._tester.line.timing.response_timeout, _CYCLES * 120 / rpm)
                seconds = min(seconds, cycles)
            response = responses.read(self._tester.link.now() + seconds)
        if response is None and not (rpm and self._rpm()):
            raise _Uncertain(_SPEED_UNKNOWN if rpm is None else _STANDING)
        return response

    def _rpm(self) -> float | None:
        """Return the engine's speed; None if the unit does not report it."""
        if self._reports_speed:
            with suppress(NotSupported):
                return float(self._parameters.read(["FREQ"])["FREQ"].value)
            self._reports_speed = False
        return None


def _lists_of(datum: c.Datum) -> tuple[tuple[c.Datum, ...], ...]:
    """Return the lists to try: one byte could be D10's 01, but some units accept one code only."""
    return (datum, datum), (datum,)
