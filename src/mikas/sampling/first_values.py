"""The first values of a unit, before its passports and limits are known: a second is long."""

from __future__ import annotations

from math import inf

from mikas.client import Ecu, Reading
from mikas.client.ecu import may_be_limited, read_at_once
from mikas.errors import EcuRefused, LineError
from mikas.sampling.context import SamplingContext
from mikas.sampling.plan import Plan

_PAUSE = 0.5  # s between two cycles; passports that are answered take 0.2 s


class FirstValues:
    """Reads all requested parameters of `ecu` by one 61, until that fails once.

    Later the unit's refusals are found and its fastest method is measured. Not if another method is
    requested; if another unit may have been sampled before (`identify_first`); if limits are saved
    for any unit, for this may be the one that does not take the whole list.
    """

    def __init__(self, context: SamplingContext, ecu: Ecu) -> None:
        request = context.request
        self.plan = Plan(request.selection.parameters, max_list=context.knowledge.max_list)
        self._context = context
        self._ecu = ecu
        self._works = (
            request.method in (None, "batch")
            and not context.identify_first
            and not may_be_limited(ecu)
        )
        self._due = -inf

    def read(self) -> dict[str, Reading]:
        """Return the readings by name; {} if the unit refuses, or soon after the last ones.

        Raises a `NoConnection`.
        """
        now = self._ecu.tester.link.now
        if not self._works or now() < self._due or not self._context.is_current:
            return {}
        parameters = [planned.parameter for planned in self.plan.parameters]
        try:
            fresh = read_at_once(self._ecu, parameters)
        except (EcuRefused, LineError):
            fresh = {}
        self._works, self._due = bool(fresh), now() + _PAUSE
        return fresh
