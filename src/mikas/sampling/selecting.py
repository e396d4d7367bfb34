"""From what a user names to what is asked: `FREQ`, `TWAT/10`, `0x1A`, `0x3F:2`, `FUEL_FLOW`.

`/10` means every tenth cycle. A derived channel needs its inputs as often as itself, and in the
same cycles; they are asked whether or not they were named.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import gcd

from mikas.catalog import Catalog, Derived, Parameter
from mikas.client.parameters import distinct
from mikas.errors import UsageError
from mikas.i18n import Text
from mikas.sampling.derived import DerivedChannels
from mikas.sampling.plan import PlannedParameter


@dataclass(frozen=True)
class Selection:
    """`channels` as they were named, each once; `wanted`: the parameters that takes.

    `named`: whether anything was named at all, and not just everything wanted.
    """

    channels: tuple[Parameter | Derived, ...]
    parameters: tuple[PlannedParameter, ...]
    derived: tuple[str, ...]
    explicit: bool


def select(catalog: Catalog, names: Iterable[str]) -> Selection:
    """What `names` select; none: all parameters. Raises `UnknownParameter`, `UsageError`."""
    every: dict[str, int] = {}
    parameters: dict[str, Parameter] = {}
    channels: dict[str, Parameter | Derived] = {}
    needed: dict[str, int] = {}  # inputs of derived channels, and what their cycles divide

    def want(parameter: Parameter, turns: int) -> None:
        parameters[parameter.name] = parameter
        every[parameter.name] = min(turns, every.get(parameter.name, turns))

    named = tuple(names)
    for name in named or [parameter.name for parameter in catalog.parameters]:
        channel, turns = _parsed(catalog, name)
        channels[channel.name] = channel
        if isinstance(channel, Parameter):
            want(channel, turns)
        else:
            for name_of_input in DerivedChannels(catalog, [channel.name]).requires:
                want(catalog.parameter(name_of_input), turns)
                needed[name_of_input] = gcd(turns, needed.get(name_of_input, turns))
    for name_of_input, common in needed.items():
        # What comes every third cycle would meet what comes every tenth in every thirtieth only.
        every[name_of_input] = gcd(common, every[name_of_input])
    distinct(list(parameters.values()))  # one code with two sizes could not be told apart
    return Selection(
        tuple(channels.values()),
        tuple(
            PlannedParameter(parameter, every[name], name in needed)
            for name, parameter in parameters.items()
        ),
        tuple(name for name, channel in channels.items() if isinstance(channel, Derived)),
        bool(named),
    )


def _parsed(catalog: Catalog, text: str) -> tuple[Parameter | Derived, int]:
    if not isinstance(text, str):
        raise UsageError(
            problem=Text(
                f"names are a list of words, as in ['TWAT', 'FREQ/10'], not {text!r}",
                f"имена — это список слов: ['TWAT', 'FREQ/10'], а не {text!r}",
            )
        )
    name, slash, turns = text.partition("/")
    channel = catalog.channel(name)
    if not slash:
        return channel, 1
    turns = turns.strip()
    if not (turns.isascii() and turns.isdigit()):
        raise UsageError(
            problem=Text(
                f"“{text}”: behind the slash is a whole number, as in TWAT/10 (every tenth cycle)",
                f"«{text}»: после черты — целое число, как в TWAT/10 (раз в десять циклов)",
            )
        )
    return channel, int(turns[:9])
