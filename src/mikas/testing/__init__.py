"""For the tests of programs that use mikas, and of links of one's own; needs pytest.

    def test_warns_when_hot(car, virtual_ecu):           # fixtures of `mikas.testing.plugin`
        car.set("TWAT", 110)
        assert warning_of(virtual_ecu)

`VirtualUnit` is a unit on a wire with simulated time, which can pass without a request;
`LineFault` is what can happen to a response. `LinkContract` is the suite that every link of mikas
passes, `RealTimeContract` the one for links whose waits are real; `Rig` is what they are run over.
Each is imported when it is first used: the plugin loads nothing before a test wants it.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mikas.testing.links import LinkContract, Peer, RealTimeContract, Rig
    from mikas.testing.units import LineFault, VirtualUnit

__all__ = ["LineFault", "LinkContract", "Peer", "RealTimeContract", "Rig", "VirtualUnit"]

_MODULES = dict.fromkeys(("LineFault", "VirtualUnit"), "mikas.testing.units") | dict.fromkeys(
    ("LinkContract", "Peer", "RealTimeContract", "Rig"), "mikas.testing.links"
)


if not TYPE_CHECKING:  # so that a misspelt name is an error for type checkers

    def __getattr__(name: str) -> object:
        if name in _MODULES:
            return getattr(import_module(_MODULES[name]), name)
        raise AttributeError(f"module 'mikas.testing' has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
