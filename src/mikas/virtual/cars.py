"""The car of the engine model: its values as the raw data of §4."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from math import inf

from mikas.catalog import Catalog, Conversion, Parameter
from mikas.errors import ValueDoesNotFit
from mikas.i18n import Text
from mikas.virtual.model.engine import FIELDS, Engine, EngineState

MINERR = "MINERR"
Encoder = Callable[[EngineState], bytes]


class EngineCar:
    """Data from `engine`, which began to run at `start` of the caller's clock.

    Values pinned by a scenario and written values (62) replace the engine's. `codes`: those of the
    catalog that the model computes. `faults`: the stored faults in the unit's order, may be changed
    at any time. A stored fault is also present: its sensor gives the substitute until it is erased.
    But those of `past` are only stored.
    """

    def __init__(
        self,
        engine: Engine,
        catalog: Catalog,
        *,
        faults: Iterable[int] = (),
        start: float = 0.0,
    ) -> None:
        self.engine = engine
        self.faults: list[int] = list(dict.fromkeys([*sorted(engine.scenario.faults), *faults]))
        self.past: frozenset[int] = frozenset()
        self._start = start
        self._latest = -inf  # when the engine's state was last used
        self._pinned = pinned(catalog, engine.scenario.raw, engine.scenario.values)
        self._written: dict[int, bytes] = {}
        encoders = {code: self._from_engine(catalog.by_code(code)) for code, _ in catalog.codes}
        self._encoders = {code: encoder for code, encoder in encoders.items() if encoder}
        self._sizes = {code: size for code, size in catalog.codes if code in self._encoders}
        self._sizes |= {code: len(datum) for code, datum in self._pinned.items()}
        self.codes: tuple[int, ...] = tuple(self._sizes)

    def _from_engine(self, parameters: tuple[Parameter, ...]) -> Encoder | None:
        """Return the encoder of the datum that `parameters` share; None: the model lacks it."""
        first = parameters[0]
        if first.name == MINERR:
            return lambda _: bytes([min(self.faults, default=0)])
        known = [(p.conversion, FIELDS[p.name]) for p in parameters if p.name in FIELDS]
        if not known:
            return None
        if first.is_flag:
            masks = [(conversion.mask, name) for conversion, name in known]
            return lambda state: bytes(
                [sum(mask for mask, name in masks if mask and getattr(state, name))]
            )
        return _encoder(first.conversion, FIELDS[first.name])

    def size_of(self, code: int) -> int | None:
        """Return the size of the datum in bytes; None: this car has no such parameter."""
        return self._sizes.get(code)

    def raw(self, code: int, now: float) -> bytes:
        """Return the datum at `now`."""
        fixed = self._written.get(code) or self._pinned.get(code)
        if fixed is not None:
            return fixed
        if now != self._latest:  # one response reads many data at one time
            self._latest = now
            self.engine.faults = [each for each in self.faults if each not in self.past]
            self.engine.advance(now - self._start)
        return self._encoders[code](self.engine.state)

    def write(self, code: int, data: bytes) -> bool:
        """Keep `data` until the next power cycle."""
        self._written[code] = data
        return True

    def engine_speed(self, now: float) -> float:
        """Return the rpm of the engine at `now`."""
        self.engine.advance(now - self._start)
        return self.engine.state.rpm

    def state(self, now: float) -> EngineState:
        """Return the car at `now`, for an instrument in it; what the unit sends is as without."""
        self.engine.advance(now - self._start)
        return self.engine.state

    def powered(self, now: float) -> bool:
        """Return whether the ignition is on."""
        return self.engine.scenario.timeline.key_on(now - self._start)

    def next_change(self, after: float) -> float:
        """Return when the key is turned next."""
        since = max(0.0, after - self._start)  # the key is not turned before the engine's start
        return self._start + self.engine.scenario.timeline.next_key_change(since)

    def next_stroke(self, stroke: int, after: float) -> float:
        """Return when the engine next reaches this stroke."""
        return self._start + self.engine.next_cycle_time(stroke, after - self._start)

    def power_cycle(self) -> None:
        """Forget written data."""
        self._written.clear()


def _encoder(conversion: Conversion, name: str) -> Encoder:
    """Return an encoder to the nearest raw datum, limited to the range of its bytes."""
    scale = float(conversion.scale)
    zero = float(conversion.offset - conversion.bias * conversion.scale)
    low, high = conversion.raw_limits
    size, signed = conversion.size, conversion.signed

    def datum(state: EngineState) -> bytes:
        number: int = round((getattr(state, name) - zero) / scale)
        return min(max(number, low), high).to_bytes(size, "little", signed=signed)

    return datum


def pinned(
    catalog: Catalog, raw: Mapping[str, bytes], values: Mapping[str, float | bool]
) -> dict[int, bytes]:
    """Return the pinned data of a scenario by code: `raw` data, and encoded physical `values`.

    Flags that share a byte are combined. Raises `UnknownParameter`, `ValueDoesNotFit`.
    """
    data = {}
    for name, datum in raw.items():
        parameter = catalog.parameter(name)
        size = parameter.size
        if len(datum) != size:
            raise ValueDoesNotFit(
                value=datum.hex(" ").upper(),
                name=name,
                allowed=Text(f"bytes in its datum: {size}", f"байтов в нём: {size}"),
            )
        data[parameter.code] = datum
    for name, value in values.items():
        parameter = catalog.parameter(name)
        if parameter.is_flag:
            mask = parameter.conversion.mask or 0
            before = data.get(parameter.code, b"\x00")[0]
            data[parameter.code] = bytes([before | mask if value else before & ~mask])
        else:
            data[parameter.code] = parameter.encode(value)
    return data
