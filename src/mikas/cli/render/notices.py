"""Sentences for events other than values: the state of the line, a dropped parameter, an alarm."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from contextlib import closing
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING

from mikas import errors
from mikas.cli.advice import ADVICE
from mikas.cli.language import capital, decimal, localized, tr
from mikas.sampling import events
from mikas.sampling.instrument_changes import InstrumentChanged

if TYPE_CHECKING:
    from mikas.cli.sampling_run import SamplingRun
    from mikas.sampling.plan import Plan

Show = Callable[[str], None]

_NAMED = (errors.AnotherAdapter, errors.AdapterTaken, errors.LineFlooded)  # shown as they are
_LASTING = 3.0  # s without a sample on a working line that are worth a notice


class Notices:
    """Follows a run's events and passes a sentence for each notable one to `show`."""

    def __init__(self, session: SamplingRun, show: Show, *, verbose: bool = False) -> None:
        self._session = session
        self._show = show
        self._verbose = verbose
        self._gap_began = -inf  # of the present gap
        self._well_since = -inf  # when the line last worked
        self._shown_state: str | None = None  # the state last shown; SAMPLING: cycles fail
        self._plan: Plan | None = None
        self._method: str | None = None  # the chosen one
        self._failure: errors.MikasError | None = None
        self._faults: tuple[int, ...] | None = None  # as read last
        session.recorder.on_file = self._new_file

    def show_event(self, event: events.Event) -> None:
        """Show the sentences for `event`."""
        for sentence in self._of(event):
            self._show(sentence)
        failure = self._session.recorder.failure
        if failure is not None and failure is not self._failure:
            self._failure = failure
            why = localized(failure.reason)
            stopped = tr(
                f"RECORDING STOPPED. {why}. Sampling continues.",
                f"ЗАПИСЬ ПРЕКРАЩЕНА. {why}. Опрос продолжается.",
            )
            self._show(stopped)

    def watch(self) -> Generator[events.Event, None, None]:
        """Yield the run's events, each after its notices; then show if its recording is over."""
        with closing(self._session.events()) as following:
            for event in following:
                self.show_event(event)  # first: the notice that values are back comes before them
                yield event
        if self._session.recording_over is not None:
            self._show(f"{localized(self._session.recording_over.reason)}.")

    def _of(self, event: events.Event) -> Iterator[str]:
        match event:
            case events.Sampled() | events.Gap():
                yield from self._values_or_gap(event)
            case events.CycleFailed():
                yield from self._failed(event)
            case events.StateChanged():
                yield from self._state(event)
            case events.AdapterMoved() | events.ClockChanged() | InstrumentChanged():
                yield f"{capital(localized(event.text))}."
            case events.UnitFound(another=True):
                self._shown_state = None  # the earlier unit is not back
                yield tr(
                    f"Another unit answers: {self._model()}. The values are now its own.",
                    f"Отвечает другой блок: {self._model()}. Дальше показаны его значения.",
                )
            case events.ParameterDropped():
                yield tr(
                    f"The unit gives no value for {event.name}; the other parameters are still "
                    "read.",
                    f"Блок не даёт {event.name}: он пропущен, остальные читаются дальше.",
                )
            case events.ParameterReturned():
                yield tr(
                    f"The unit answers {event.name} again; it is read from now on.",
                    f"Блок снова даёт {event.name}, он опять читается.",
                )
            case events.AlarmChanged():
                yield f"{'✓' if event.better else '▲'} {capital(localized(event.text))}."
            case events.FaultReading():
                yield from self._faults_read(event)
            case events.MethodChosen() if self._verbose:
                yield from self._method_chosen(event)
            case events.PlanChanged() if self._verbose:
                yield from self._planned(event.plan)

    def _faults_read(self, event: events.FaultReading) -> Iterator[str]:
        """Yield the stored faults when they are read first, and when they have changed."""
        before, self._faults = self._faults, event.codes
        numbers = ", ".join(map(str, event.codes))
        if before is None and event.codes:
            yield tr(f"Stored faults: {numbers}.", f"Ошибки в памяти: {numbers}.")
        elif before is not None and set(before) != set(event.codes):
            new = ", ".join(str(code) for code in event.codes if code not in before)
            if new:
                yield tr(f"▲ New fault: {new}.", f"▲ Новая ошибка: {new}.")
            else:
                now = numbers or tr("none", "нет")
                yield tr(f"Stored faults now: {now}.", f"Ошибки в памяти теперь: {now}.")

    def _values_or_gap(self, event: events.Sampled | events.Gap) -> Iterator[str]:
        """Yield that values are back, if it was shown that they were away."""
        if isinstance(event, events.Sampled):
            self._shown_state = None
        elif event.ended is None:
            self._gap_began = event.began
        elif self._shown_state is not None:
            seconds = f"{event.ended - event.began:.0f}"
            yield tr(f"Back after {seconds} s.", f"Связь вернулась через {seconds} с.")

    def _failed(self, event: events.CycleFailed) -> Iterator[str]:
        """Yield why cycles fail, once they have failed for `_LASTING`."""
        if (
            isinstance(event.error, errors.NoConnection | errors.SyncLost)
            or self._shown_state is events.LineState.SAMPLING
        ):
            return  # the line's state says it, or it was said
        since = max(self._gap_began, self._well_since)
        if isinstance(event.error, errors.EngineStopped) or event.time - since >= _LASTING:
            self._shown_state = events.LineState.SAMPLING
            yield _with_advice(event.error)

    def _planned(self, plan: Plan) -> Iterator[str]:
        self._plan = plan
        if self._session.options.method == "auto" and plan.method != self._method:
            yield tr(
                "Testing sampling methods (about 1 s each) …",
                "Проверка способов опроса (около 1 с на каждый) …",
            )
        else:
            yield plan_sentence(plan)

    def _method_chosen(self, event: events.MethodChosen) -> Iterator[str]:
        self._method = event.method
        yield method_sentence(event, self._session.options.rate)
        if self._plan is not None and self._plan.method == event.method:
            yield plan_sentence(self._plan)  # no PlanChanged follows

    def _state(self, event: events.StateChanged) -> Iterator[str]:
        if not event.is_broken:
            self._well_since = event.time
        elif self._session.connected:
            if isinstance(event.error, _NAMED):
                yield f"{localized(event.error.text)} {_waits()}"
            elif event.state is self._shown_state:
                pass  # a new reason alone is not shown
            elif isinstance(event.error, errors.LineNotQuiet):  # the unit is not silent
                yield _with_advice(event.error)
            else:
                state = capital(localized(event.text))
                yield f"{state}{'' if state.endswith('?') else '.'} {_waits()}"
            self._shown_state = event.state
            if self._verbose and event.error is not None:
                yield localized(ADVICE.text(event.error))

    def _model(self) -> str:
        return localized(self._session.model) if self._session.model else "?"

    def _new_file(self, path: Path) -> None:
        self._show(tr(f"Recording continues in {path}.", f"Запись продолжается в {path}."))


def _with_advice(error: errors.MikasError) -> str:
    """Return the reason, what to try, and that sampling resumes."""
    sentences = (f"{localized(error.reason)}.", localized(ADVICE.advice(error)), _waits())
    return " ".join(sentence for sentence in sentences if sentence)


def _waits() -> str:
    return tr("Waiting; sampling resumes by itself.", "Ждём; опрос продолжится сам.")


def plan_sentence(plan: Plan) -> str:
    """Return a sentence for the cost of a cycle of `plan`."""
    price = plan.price()
    size, milliseconds = f"{price.bytes:.0f}", f"{price.seconds * 1000:.0f}"
    rate = decimal(f"{price.rate:.1f}")
    return tr(
        f"Plan: {plan.method}, {size} bytes and {milliseconds} ms per cycle, at most {rate} "
        "readings/s.",
        f"План: {plan.method}, байт на цикл: {size}, мс на цикл: {milliseconds}, не больше {rate} "
        "опр/с.",
    )


def method_sentence(event: events.MethodChosen, enough: float | None = None) -> str:
    """Return the method and the rates of those that were measured; a dash: it does not work.

    `enough`: the wanted rate, for which a slower method may have been taken.
    """
    rates = ", ".join(
        f"{name} {rate:.1f}" if rate else f"{name} –" for name, rate in event.rates.items()
    )
    if not rates:
        return tr(f"Method: {event.method}.", f"Способ: {event.method}.")
    why, ru_why = ".", "."
    if enough is not None and event.rates.get(event.method, 0.0) < max(event.rates.values()):
        wanted = f"{enough:g}"
        why = f": enough for the requested {wanted}, with the least load on the unit."
        ru_why = f": для заданных {decimal(wanted)} достаточно, нагрузка на блок наименьшая."
    return tr(
        f"Method: {event.method} (readings/s: {rates}){why}",
        f"Способ: {event.method} (опр/с: {decimal(rates)}){ru_why}",
    )
