"""Erasing the stored faults: two writes in a row (§3), which pass the gate."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

from mikas import commands as c
from mikas.catalog import Fault
from mikas.client.gate import Change, Gate
from mikas.errors import NoResponse, NotSupported
from mikas.i18n import Text, counted, joined
from mikas.tester import Tester

_NO_FAULTS: Final = Text("no faults", "ошибок нет")


@dataclass(frozen=True, slots=True)
class Erased:
    """The faults that were stored before an erase, and those stored after it."""

    before: tuple[Fault, ...]
    """The faults before the erase."""
    after: tuple[Fault, ...]
    """Those that are stored still."""


def erasing(count: int) -> Text:
    """Return the text for erasing `count` faults."""
    faults = counted(count, ("stored fault", "stored faults"), ("ошибку", "ошибки", "ошибок"))
    return Text("erase {faults}", "сбросить {faults}").filled(faults=faults)


def engine_runs(rpm: float) -> Text:
    """Return the warning before faults are erased with the engine running."""
    return Text(
        f"The engine is running ({rpm:.0f} rpm). Stop it, switch the ignition on, and erase then.",
        f"Двигатель работает ({rpm:.0f} об/мин). Заглушите его, включите зажигание и только потом "
        "сбрасывайте.",
    )


def erase(
    tester: Tester,
    gate: Gate,
    stored: Callable[[], tuple[Fault, ...]],
    engine_speed: Callable[[], float | None],
) -> Erased:
    """Erase the faults. `stored` reads them; `engine_speed`: where changes are confirmed.

    Raises `NotConfirmed`, `WriteRefused`.
    """
    before = stored()
    old = joined(", ", map(_in_words, before)) if before else _NO_FAULTS
    change = Change.by(
        c.WriteParameter, erasing(len(before)), _codes(before), b"", old=old, new=_NO_FAULTS
    )
    if gate.asks and (rpm := engine_speed()):
        change = replace(change, warning=engine_runs(rpm))

    def act() -> Erased:
        try:
            tester.in_a_row(*c.ERASE_FAULTS)
        except (NoResponse, NotSupported) as error:
            if error.received:
                raise
            # Perhaps only an answer was lost; erasing twice has the same effect.
            tester.in_a_row(*c.ERASE_FAULTS)
        return Erased(before, stored())

    return gate.make(change, act, lambda erased: _codes(erased.after))


def _in_words(fault: Fault) -> Text:
    return fault.text if fault.text.en else Text(f"fault {fault.code}", f"ошибка {fault.code}")


def _codes(faults: Sequence[Fault]) -> bytes:
    return bytes(fault.code for fault in faults)
