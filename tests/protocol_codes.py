"""The parameters of §4 of docs/protocol.md, fixed: the shipped catalog may hold more.

A test that means the codes of §4 (the data of `vectors`, the arithmetic of §5) takes them from
here. A test that means everything shipped derives its numbers from `mikas.catalog.shipped()`.
"""

from __future__ import annotations

from dataclasses import replace

from mikas.catalog import AlarmLimits, Catalog, shipped
from mikas.virtual.build import build_bus

# Each mnemonic with its code, in the order of §4; RXX, BITPOW and RDET share a code.
CODE_OF = {
    "TWAT": 0x1A, "FREQ": 0x29, "FREQX": 0x2C, "UOZ": 0x26, "UACC": 0x1E, "INJ": 0x3F,
    "JAIR": 0x21, "JQT": 0x40, "DET": 0x08, "RXX": 0x07, "BITPOW": 0x07, "RDET": 0x07,
    "VALF": 0x39, "THR": 0x20, "RCOK": 0x42, "RCOD": 0x41, "UOZOC": 0x28, "SSM": 0x5B,
    "FSM": 0x5C, "MINERR": 0x72, "UGB": 0x59, "TAIR": 0x1C, "TWATI": 0x19,
}  # fmt: skip
NAMES = tuple(CODE_OF)  # 23
CODES = tuple(dict.fromkeys(CODE_OF.values()))  # 21
TWO_BYTES = frozenset({0x3F, 0x21, 0x40, 0x59})  # every other code has one data byte: 25 in all

SIMULATED = len(build_bus({}).ecu.responder.car.codes)
"""The number of codes that the virtual ECU answers: those of §4, and others that it simulates."""

SECTION_4 = Catalog(
    parameters=tuple(map(shipped().parameter, NAMES)),
    derived=shipped().derived,
    faults=shipped().faults,
    models=shipped().models,
    errata=shipped().errata,
    units=shipped().units,
    version=shipped().version,
)


def with_limits(catalog: Catalog, **limits: AlarmLimits | None) -> Catalog:
    """Return `catalog` with other limits of these channels."""
    return replace(
        catalog,
        parameters=tuple(
            replace(each, alarm_limits=limits.get(each.name, each.alarm_limits))
            for each in catalog.parameters
        ),
        derived={
            name: replace(each, alarm_limits=limits.get(name, each.alarm_limits))
            for name, each in catalog.derived.items()
        },
    )
