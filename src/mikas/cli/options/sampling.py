"""The options that `watch` and `log` share.

Nothing heavy is imported here: the port is opened first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from mikas.cli.click_extensions import argument, grouped, option, option_field, optional_field
from mikas.cli.completion.values import channel_names, instruments, methods
from mikas.cli.options.common import RELEARN
from mikas.cli.options.parameter_types import OneOf, positive, whole

_DEFAULT = "auto"


def _method(text: str) -> str:
    if text == _DEFAULT:
        return text
    from mikas.client import METHODS

    return OneOf(METHODS).convert(text, None, None)


@dataclass(frozen=True, slots=True)
class SamplingOptions:
    """The options of sampling. `count` and `duration` None: until Ctrl-C."""

    names: Sequence[str] = ()
    method: str = option_field(
        _DEFAULT,
        "--method",
        type=_method,
        metavar="METHOD",
        shell_complete=methods,
        en="sampling method: auto (the fastest that works), single, batch, list, stream, stroke0 "
        "… stroke4",
        ru="способ опроса: auto (самый быстрый из работающих), single, batch, list, stream, "
        "stroke0 … stroke4",
    )
    rate: float | None = optional_field(
        "--rate",
        parse=positive,
        metavar="HZ",
        en="at most this many readings/s",
        ru="опросов в секунду, не больше",
    )
    count: int | None = optional_field(
        "--count",
        parse=whole(1),
        metavar="N",
        en="stop after this many samples",
        ru="остановиться после стольких замеров",
    )
    duration: float | None = optional_field(
        "--duration",
        parse=positive,
        metavar="S",
        en="stop after this many seconds",
        ru="остановиться через столько секунд",
    )


sampling_options: Final = grouped(
    SamplingOptions,
    argument("names", "[NAME[/N]]...", nargs=-1, shell_complete=channel_names),
    RELEARN,
)
"""The options that `watch` and `log` share."""

INSTRUMENTS: Final = option(
    "--instrument",
    "instruments",
    multiple=True,
    metavar="NAME=URL",
    shell_complete=instruments,
    en="a λ meter or GPS beside the unit: aem, 14point7, innovate, nmea, gpsd or a file.toml, at "
    "its port: aem=/dev/ttyUSB1, gpsd=gpsd:localhost:2947",
    ru="лямбда-прибор или GPS рядом с блоком: aem, 14point7, innovate, nmea, gpsd или файл.toml, "
    "на своём порту: aem=/dev/ttyUSB1, gpsd=gpsd:localhost:2947",
)
"""Instruments beside the unit."""
