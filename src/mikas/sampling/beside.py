"""Samples of the unit with what instruments beside it give: values, derived channels, alarms.

    sample, values of instruments ──► SamplesBeside.completed ──► sample with both
                                      SamplesBeside.alarms    ──► the changes of their alarms

A derived channel that needs an instrument is computed here, after the others: the loop that asks
the unit knows no instrument. Its totals count from the first sample of this object.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from mikas.catalog import Derived, InstrumentChannel
from mikas.client.parameters.derived import DerivedChannels, DerivedValue
from mikas.instruments.reading import InstrumentReading
from mikas.sampling.alarms import Alarms, Value
from mikas.sampling.events import AlarmChanged, Sampled
from mikas.sampling.plan import Selection


class SamplesBeside:
    """The instruments' part of the samples of one session. One thread calls.

    `instruments`: the channels of the instruments.
    """

    def __init__(self, instruments: Iterable[InstrumentChannel]) -> None:
        self._instruments = tuple(instruments)
        self._derived: DerivedChannels | None = None
        self._selection: Selection | None = None
        self._alarms = Alarms(self._instruments)
        self._ended: list[AlarmChanged] = []  # by other limits, not reported yet

    def completed(
        self,
        sample: Sampled,
        instruments: Mapping[str, InstrumentReading],
        selection: Selection,
    ) -> Sampled:
        """Return the sample with the instruments' values, and the channels computed from them.

        `selection`: what the session samples, with its derived channels.
        """
        if selection is not self._selection:
            self._use(selection, sample.time)
        found: dict[str, DerivedValue] = {}
        if self._derived is not None:
            known: dict[str, InstrumentReading | DerivedValue] = {**instruments, **sample.derived}
            found = self._derived.update(sample.fresh, sample.time, beside=known)
        return replace(sample, instruments=instruments, derived={**sample.derived, **found})

    def alarms(self, sample: Sampled) -> list[AlarmChanged]:
        """Return the changes of alarms by a `completed` sample.

        An alarm ends with the values of the instrument that its channel needs.
        """
        known, derived = sample.instruments, self._channels
        values: dict[str, Value] = {it.name: it.value for it in known.values()}
        values |= {it.name: sample.derived.get(it.name) for it in derived}
        needs: dict[str, tuple[str, ...]] = {it.name: (it.name,) for it in self._instruments}
        if (selection := self._selection) is not None:
            needs |= {it.name: selection.catalog.required_beside([it.name]) for it in derived}
        gone = [name for name in self._alarms.states if any(it not in known for it in needs[name])]
        ended, self._ended = self._ended, []
        changed = self._alarms.update(values, sample.time)
        return [*ended, *changed, *self._alarms.lose(gone, sample.time)]

    def use_instruments(
        self, instruments: Iterable[InstrumentChannel], time: float
    ) -> list[AlarmChanged]:
        """Take the same channels with other limits; return the ends of alarms by those before."""
        self._instruments = tuple(instruments)
        self._use_limits(time)
        ended, self._ended = self._ended, []
        return ended

    @property
    def _channels(self) -> tuple[Derived, ...]:
        return self._derived.channels if self._derived is not None else ()

    def _use(self, selection: Selection, time: float) -> None:
        catalog, before = selection.catalog, self._derived
        names = [name for name in selection.derived if catalog.required_beside([name])]
        self._selection = selection
        self._derived = DerivedChannels(catalog, names) if names else None
        if before is not None and self._derived is not None:
            self._derived.continue_from(before, catalog.required_by(names))
        self._use_limits(time)

    def _use_limits(self, time: float) -> None:
        before = self._alarms
        self._alarms = Alarms((*self._instruments, *self._channels))
        self._ended += self._alarms.continue_from(before, time)
