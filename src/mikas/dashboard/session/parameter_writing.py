"""Writing a parameter (62) as `mikas write` does: shown with its bounds, confirmed, read back.

The change goes through the client library's gate, which journals it. The value before the first
write stays in `StartValues`, for the way back. An error says what to do at the parameter's sheet,
which reads the unit again after each attempt.
"""

from __future__ import annotations

from dataclasses import dataclass

from mikas.catalog import AlarmLimits, Parameter
from mikas.client import Ecu, Reading
from mikas.client.gate import journal_hex
from mikas.client.parameters.parameters import KEEPING_UNKNOWN, datum_to_write
from mikas.client.parameters.readings import decode
from mikas.dashboard.errors import BadRequest
from mikas.dashboard.security.control import PendingChange, ValueShown, WriteApproval
from mikas.dashboard.session.catalog_in_use import CatalogInUse
from mikas.dashboard.session.connection import Connection
from mikas.dashboard.session.start_values import StartValues
from mikas.errors import (
    LineError,
    MikasError,
    NoResponse,
    NotSupported,
    ReadBackDiffers,
    WriteRefused,
)
from mikas.i18n import Text
from mikas.recording.formatting import digits, joined_unit

_UNREADABLE = Text("not readable", "не читается")
_SILENT = Text(
    "The value is read again: if it is the old one, nothing was written. Check that the ignition "
    "is on, then write once more. A unit that stays silent does not know the command (62).",
    "Значение читается снова: если оно прежнее, ничего не записано. Проверьте, включено ли "
    "зажигание, и запишите ещё раз. Если блок снова молчит, он не знает этой команды (62).",
)
_DAMAGED = Text(
    "Whether it was written is uncertain: the value is read again. Look at it before you write "
    "once more.",
    "Записано ли значение, неясно: оно читается снова. Посмотрите на него, прежде чем писать ещё "
    "раз.",
)
_ADVICE: tuple[tuple[type[MikasError], Text], ...] = (
    (
        WriteRefused,
        Text(
            "The unit answered 01, and the value is as before. It does not let this parameter be "
            "written, or not now: try once with the ignition on and the engine off.",
            "Блок ответил 01, значение прежнее. Этот параметр он записать не даёт — или не даёт "
            "сейчас: попробуйте один раз при включённом зажигании и заглушенном моторе.",
        ),
    ),
    (
        ReadBackDiffers,
        Text(
            "The unit's program changes this value, or limits it. Look at the value that it holds "
            "now; go back to the start value if the engine runs badly.",
            "Программа блока сама меняет это значение или ограничивает его. Посмотрите, что в "
            "блоке теперь; если мотор работает плохо, верните начальное значение.",
        ),
    ),
    (NoResponse, _SILENT),
    (NotSupported, _SILENT),
    (LineError, _DAMAGED),
)


@dataclass(frozen=True, slots=True)
class ParameterNow:
    """A parameter as the unit holds it, what can be written, and its start value."""

    name: str
    now: ValueShown | None
    time: float
    lowest: float | None
    highest: float | None
    step: float | None
    start: ValueShown | None
    start_time: float | None


@dataclass(slots=True)
class ParameterWriting:
    """Shows, prepares and makes writes of parameters on the connection."""

    _connection: Connection
    _approval: WriteApproval
    _interpretation: str
    _catalogs: CatalogInUse
    starts: StartValues

    async def look(self, name: str) -> ParameterNow:
        """Read a parameter. Raises for an unknown one, and the errors of the line."""
        parameter = self._catalogs.catalog.parameter(name)
        reading = await self._connection.ask(lambda ecu: _read(ecu, parameter))
        now = self._connection.date()
        conversion = parameter.interpretation(self._interpretation)
        start = self.starts.value(parameter.name, now)
        lowest, highest = conversion.limits or (None, None)
        return ParameterNow(
            parameter.name,
            _shown(reading),
            now if reading is None else reading.time + self._connection.later,
            lowest,
            highest,
            None if conversion.is_flag else abs(float(conversion.scale)),
            _shown(self._decoded(parameter, start.raw)) if start else None,
            start.read if start else None,
        )

    async def proposal(self, name: str, *, value: float | None, raw: str | None) -> PendingChange:
        """Prepare writing a physical `value`, or the `raw` bytes in hex.

        Raises for an unknown parameter, and for a value that does not fit it.
        """
        parameter = self._catalogs.catalog.parameter(name)
        if (value is None) == (raw is None):
            raise BadRequest(
                problem=Text(
                    "give either a value or raw bytes", "нужно или значение, или исходные байты"
                )
            )
        given = None if raw is None else bytes.fromhex(raw)
        datum = datum_to_write(parameter, value, given, self._interpretation)
        before = await self._connection.ask(lambda ecu: _read(ecu, parameter))

        def write(ecu: Ecu) -> ValueShown | None:
            if before is not None:
                self.starts.note(parameter.name, before.raw, ecu.tester.link.date())
            try:
                with self._approval.given_to(parameter.name, journal_hex(datum)):
                    return _shown(ecu.write_parameter(parameter.name, raw=datum).after)
            except MikasError as error:
                _advise(error)
                raise

        after = self._decoded(parameter, datum)
        beyond = self._beyond(parameter, after)
        return PendingChange(
            what=Text(f"write parameter {parameter.name}", f"записать параметр {parameter.name}"),
            before=_shown(before),
            after=_shown(after),
            make=lambda: self._connection.ask(write),
            danger=beyond is not None,
            meaning=_joined(
                Text("{name}: {before} → {after}.", "{name}: {before} → {after}.").filled(
                    name=parameter.text,
                    before=_UNREADABLE if before is None else _in_words(before),
                    after=_in_words(after),
                ),
                beyond,
                KEEPING_UNKNOWN,
            ),
            needs_unlock=True,
        )

    def _decoded(self, parameter: Parameter, raw: bytes) -> Reading:
        return decode(parameter, raw, self._connection.now(), self._interpretation)

    def _beyond(self, parameter: Parameter, after: Reading) -> Text | None:
        """Return the catalog's limit that the new value is beyond; None: it is within all.

        The limits are in the unit of the corrected interpretation only.
        """
        if parameter.interpretation(self._interpretation) != parameter.conversion:
            return None
        value = float(after.value)
        limit = _crossed(parameter.alarm_limits, value)
        if limit is not None:
            return Text(
                f"That is beyond the limit {limit:g}, which the catalog calls dangerous.",
                f"Это за пределом {limit:g}, который каталог называет опасным.",
            )
        plausible = parameter.plausible
        if plausible is not None and not plausible[0] <= value <= plausible[1]:
            return Text(
                f"That is outside {plausible[0]:g} … {plausible[1]:g}, the values that occur on "
                "an engine.",
                f"Это вне диапазона {plausible[0]:g} … {plausible[1]:g}, который бывает на "
                "двигателе.",
            )
        return None


def _in_words(reading: Reading) -> Text:
    """Return the value with its unit, as the page shows values."""
    parameter = reading.parameter
    if parameter.is_flag:
        return reading.shown
    unit = parameter.interpretation(reading.interpretation).unit_text
    return joined_unit(digits(float(reading.value), parameter.decimals), unit)


def _crossed(limits: AlarmLimits | None, value: float) -> float | None:
    """Return the dangerous limit that `value` is beyond; None: it is beyond none."""
    low, high = (limits.danger_low, limits.danger_high) if limits else (None, None)
    if low is not None and value < low:
        return low
    return high if high is not None and value > high else None


def _advise(error: MikasError) -> None:
    """Replace the class's own advice by that for a write; an individual one stays."""
    if not error.has_class_advice:
        return
    for kind, advice in _ADVICE:
        if isinstance(error, kind):
            error.advice = advice
            return


def _joined(*texts: Text | None) -> Text:
    given = [text for text in texts if text is not None]
    return Text(" ".join(it.en for it in given), " ".join(it.ru for it in given))


def _read(ecu: Ecu, parameter: Parameter) -> Reading | None:
    try:
        value = ecu.read(parameter.name)[parameter.name]
    except NotSupported:
        return None
    return value if isinstance(value, Reading) else None


def _shown(reading: Reading | None) -> ValueShown | None:
    return ValueShown(reading.value, reading.unit, reading.raw.hex().upper()) if reading else None
