"""From names and rates to requests, and their price (§5, D11).

A name is `FREQ`, `TWAT/10` (every tenth cycle), `0x1A`, `0x3F:2` or a derived channel's, which
needs its inputs as often as itself and in the same cycles.

A plan sends nothing. Parameters that share a byte are requested once (RXX, BITPOW and RDET).
Parameters of a divisor are spread over its cycles, to make the cycles about equally long; inputs
of a derived channel stay in one cycle. A cycle without requests lasts as long as one with requests.

Where each parameter costs time in each cycle (requests by 61), some may come first: the others are
then requested in every fifth cycle (`Plan.preferring`). A stream (71) or a list (63) has all of
them at the price of their bytes: on the virtual unit 34 and 29 cycles a second with all parameters,
by 61 17.5, and 31 with eight of them first. A list of eight and the others by 61 is no faster than
one list of all on an adapter with a latency timer of 16 ms, and each other choice would set it
again (64).

A price (§5) is the bytes at the baud rate plus the unit's turn-round for each request. Data count
as random, so two in 256 bytes are stuffed; a request's stuffing is counted exactly.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import gcd, lcm

from mikas.catalog import Catalog, Derived, Parameter
from mikas.client.parameters.data import distinct
from mikas.client.parameters.polling import STREAMS, FixedMethod
from mikas.commands import Datum
from mikas.errors import usage_error
from mikas.framing import encode

_STUFFED = 2 / 256  # of random bytes: 0D and 40 take two bytes on the wire
_LARGEST_DIVISOR = 1000
_MOST_AVERAGED = 2 * _LARGEST_DIVISOR  # cycles
_OTHERS = 5
"""Cycles in which the parameters that do not come first are requested once; 3 gives 27 cycles a
second, 10 gives 34."""
_EACH_COSTS = frozenset({"batch", "single"})


def datum_of(parameter: Parameter) -> Datum:
    """Return the unit's datum that holds `parameter`."""
    return Datum(parameter.code, parameter.size)


@dataclass(frozen=True, slots=True)
class PlannedParameter:
    """A parameter and its divisor: 10 means every tenth cycle.

    `aligned`: in the same cycles as the other aligned ones, the inputs of derived channels.
    """

    parameter: Parameter
    """The definition."""
    divisor: int = 1
    """It is read in every cycle (1), or in every tenth (10)."""
    aligned: bool = False

    def __post_init__(self) -> None:
        if not 1 <= self.divisor <= _LARGEST_DIVISOR:
            raise usage_error(
                f"{self.parameter.name}: every {self.divisor} cycles; allowed: 1 to "
                f"{_LARGEST_DIVISOR}",
                f"{self.parameter.name}: раз в {self.divisor} циклов; можно от 1 до "
                f"{_LARGEST_DIVISOR}",
            )


@dataclass(frozen=True, slots=True)
class Price:
    """The average cost of a cycle: bytes on the wire, requests, seconds."""

    bytes: float
    requests: float
    seconds: float

    @property
    def rate(self) -> float:
        """Cycles a second, at best."""
        return 1 / self.seconds


@dataclass(frozen=True)
class Plan:
    """Parameters, the method that reads them, and the longest list of codes in one request."""

    parameters: tuple[PlannedParameter, ...]
    """The parameters with their divisors."""
    method: FixedMethod = "batch"
    """The method that reads them."""
    max_list: int = 255
    """The most codes in one request."""

    def __post_init__(self) -> None:
        if not self.parameters:
            raise usage_error("nothing is chosen", "ничего не выбрано")
        if self.max_list < 1:
            raise ValueError("a list has at least one code")

    @cached_property
    def divisors(self) -> dict[Datum, int]:
        """The divisor of each code: the smallest of the parameters that share it."""
        divisors: dict[Datum, int] = {}
        for planned in self.parameters:
            datum = datum_of(planned.parameter)
            divisors[datum] = min(planned.divisor, divisors.get(datum, planned.divisor))
        return divisors

    @cached_property
    def _offsets(self) -> dict[Datum, int]:
        """The cycle of its divisor in which each code is due; the first if aligned."""
        aligned = {datum_of(planned.parameter) for planned in self.parameters if planned.aligned}
        offsets = dict.fromkeys(aligned, 0)
        used = {self.divisors[datum]: 1 for datum in aligned}
        for datum, divisor in self.divisors.items():
            if datum not in aligned:
                offsets[datum] = used.get(divisor, 0) % divisor
                used[divisor] = used.get(divisor, 0) + 1
        return offsets

    @cached_property
    def fast(self) -> tuple[Datum, ...]:
        """The codes of a list or a stream: all for a stream, else those of the highest rate."""
        if self.method in STREAMS:
            return tuple(self.divisors)
        smallest = min(self.divisors.values())
        return tuple(datum for datum, divisor in self.divisors.items() if divisor == smallest)

    def due(self, cycle: int) -> tuple[Datum, ...]:
        """Return the codes due in this cycle, counted from 0; of a stream all."""
        if self.method in STREAMS:
            return self.fast
        divisors = self.divisors.items()
        return tuple(datum for datum, every in divisors if cycle % every == self._offsets[datum])

    def reads_as(self, other: Plan) -> bool:
        """Return whether both plans send the same requests in the same cycles."""
        return (
            (self.method, self.max_list) == (other.method, other.max_list)
            and list(self.divisors.items()) == list(other.divisors.items())
            and self._offsets == other._offsets
        )

    def requests(self, cycle: int) -> list[tuple[Datum, ...]]:
        """Return the lists requested by 61 in this cycle, besides 63 or a stream."""
        if self.method in STREAMS:
            return []
        due = self.due(cycle)
        if self.method == "list":
            due = tuple(datum for datum in due if datum not in self.fast)
        size = 1 if self.method == "single" else self.max_list
        return [due[at : at + size] for at in range(0, len(due), size)]

    def sends_in(self, cycle: int) -> bool:
        """Return whether the cycle has requests or a stream; else the wire is idle."""
        return self.method in STREAMS or self.reads_list(cycle) or bool(self.requests(cycle))

    @cached_property
    def busy_share(self) -> float:
        """The share of cycles with requests or a stream."""
        cycles = min(self.period, _MOST_AVERAGED)
        return sum(map(self.sends_in, range(cycles))) / cycles

    def reads_list(self, cycle: int) -> bool:
        """Return whether 63 is sent in this cycle."""
        return self.method == "list" and cycle % min(self.divisors.values()) == 0

    def price(self, *, baud: int = 9600, turn_round: float = 0.002, pause: float = 0.0) -> Price:
        """Return the average over the cycles in which every code is due.

        `turn_round`: seconds from a request to its response; `pause`: between those of a stream.
        """
        cycles = min(self.period, _MOST_AVERAGED)
        size = count = 0.0
        for cycle in range(cycles):
            for request in self.requests(cycle):
                size += len(encode(bytes([0x61, *(d.code for d in request)])))
                size += _response(request)
                count += 1
            if self.reads_list(cycle):
                size += len(encode(b"\x63")) + _response(self.fast)
                count += 1
            if self.method in STREAMS:
                size += _response(self.fast)  # no request, and so no turn-round (§5)
        size, count = size / cycles, count / cycles
        waited = pause if self.method in STREAMS else count * turn_round
        return Price(size, count, (size * 10 / baud + waited) / self.busy_share)

    @cached_property
    def period(self) -> int:
        """The cycles after which the same requests come again."""
        return lcm(*self.divisors.values())

    def preferring(self, first: Collection[str]) -> Plan:
        """Return this plan with the parameters outside `first` in every fifth cycle only.

        Unchanged if the method reads all in one response, if none or all come first, and if
        divisors are given: these are the user's own choice.
        """
        names = {planned.parameter.name for planned in self.parameters}
        own = any(planned.divisor > 1 for planned in self.parameters)
        if self.method not in _EACH_COSTS or own or names.isdisjoint(first):
            return self
        return replace(
            self,
            parameters=tuple(
                planned if planned.parameter.name in first else replace(planned, divisor=_OTHERS)
                for planned in self.parameters
            ),
        )

    def with_method(self, method: FixedMethod) -> Plan:
        """Return this plan with another method."""
        return Plan(self.parameters, method, self.max_list)


def _response(data: Sequence[Datum]) -> float:
    """Return the length of a response: data and checksum as random bytes, and 0D."""
    return (sum(d.size for d in data) + 1) * (1 + _STUFFED) + 1


@dataclass(frozen=True)
class Selection:
    """The named `channels`, each once, and their `parameters`. `explicit`: names were given.

    `catalog`: which defines them.
    """

    catalog: Catalog
    channels: tuple[Parameter | Derived, ...]
    parameters: tuple[PlannedParameter, ...]
    derived: tuple[str, ...]
    explicit: bool


def select(catalog: Catalog, names: Iterable[str]) -> Selection:
    """Return the selection of `names`; none: all parameters.

    Raises `UnknownParameter`, `UsageError`.
    """
    divisors: dict[str, int] = {}
    parameters: dict[str, Parameter] = {}
    channels: dict[str, Parameter | Derived] = {}
    inputs: dict[str, int] = {}  # divisors of the inputs of derived channels

    def add(parameter: Parameter, divisor: int) -> None:
        parameters[parameter.name] = parameter
        divisors[parameter.name] = min(divisor, divisors.get(parameter.name, divisor))

    named = tuple(names)
    for name in named or [parameter.name for parameter in catalog.parameters]:
        channel, divisor = _parse(catalog, name)
        channels[channel.name] = channel
        if isinstance(channel, Parameter):
            add(channel, divisor)
        else:
            for required in catalog.required_by([channel.name]):
                add(catalog.parameter(required), divisor)
                inputs[required] = gcd(divisor, inputs.get(required, divisor))
    for required, common in inputs.items():
        # Inputs of every third and of every tenth cycle coincide in every thirtieth only.
        divisors[required] = gcd(common, divisors[required])
    distinct(list(parameters.values()))  # one code with two sizes is ambiguous
    return Selection(
        catalog,
        tuple(channels.values()),
        tuple(
            PlannedParameter(parameter, divisors[name], name in inputs)
            for name, parameter in parameters.items()
        ),
        tuple(name for name, channel in channels.items() if isinstance(channel, Derived)),
        bool(named),
    )


def _parse(catalog: Catalog, text: str) -> tuple[Parameter | Derived, int]:
    if not isinstance(text, str):
        raise usage_error(
            f"names are a list of words, as in ['TWAT', 'FREQ/10'], not {text!r}",
            f"имена задаются списком: ['TWAT', 'FREQ/10'], а не {text!r}",
        )
    name, slash, divisor = text.partition("/")
    channel = catalog.channel(name)
    if not slash:
        return channel, 1
    divisor = divisor.strip()
    if not (divisor.isascii() and divisor.isdigit()):
        raise usage_error(
            f"“{text}”: after the slash a whole number, as in TWAT/10 (every tenth cycle)",
            f"«{text}»: после черты — целое число, как в TWAT/10 (раз в десять циклов)",
        )
    return channel, int(divisor[:9])
