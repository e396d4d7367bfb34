"""What happens beside the values, in one sentence each: the line's state, a drop, an alarm.

On stderr for plain lines and JSON; in the live table's last line, and under it at its end.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING

from mikas.cli.advice import ADVICE
from mikas.cli.language import decimal, localized, tr
from mikas.errors import EngineStopped, MikasError, NoConnection, SyncLost
from mikas.sampling.alarms import AlarmChanged
from mikas.sampling.events import (
    CycleFailed,
    LineState,
    MethodChosen,
    ParameterDropped,
    PlanChanged,
    Sampled,
    StateChanged,
    UnitFound,
)

if TYPE_CHECKING:
    from mikas.cli.sampling_run import SamplingRun
    from mikas.sampling.events import Event
    from mikas.sampling.plan import Plan

Tell = Callable[[str], None]

_LASTING = 3.0  # s without a sample, though the line is well, that are worth a word


class Notices:
    """Follows a session's events and hands each sentence to `tell`. `verbose`: more of them.

    Nothing is said while all is well: the values speak.
    """

    def __init__(self, session: SamplingRun, tell: Tell, *, verbose: bool = False) -> None:
        self._session = session
        self._tell = tell
        self._verbose = verbose
        self._sampled: float | None = None  # when the latest sample came
        self._began: float | None = None  # when the line was last found well
        self._broken: float | None = None  # since when: from the last sample, as a gap is recorded
        self._waiting: LineState | None = None  # told; SAMPLING: the line is well, nothing comes
        self._plan: Plan | None = None
        self._method: str | None = None  # that was chosen
        self._failure: MikasError | None = None
        session.recorder.on_file = self._new_file

    def take(self, event: Event) -> None:
        """Says what there is to say of `event`."""
        for sentence in self._of(event):
            self._tell(sentence)
        failure = self._session.recorder.failure
        if failure is not None and failure is not self._failure:
            self._failure = failure
            self._tell(stopped(failure))

    def end(self) -> None:
        """Says why it has ended, if nobody asked for that."""
        if self._session.over is not None:
            self._tell(f"{localized(self._session.over.reason)}.")

    def _of(self, event: Event) -> Iterator[str]:
        match event:
            case Sampled():
                yield from self._came(event)
            case CycleFailed():
                yield from self._lost(event)
            case StateChanged():
                yield from self._state(event)
            case UnitFound(another=True):
                self._broken = self._waiting = None  # the other one is not back
                yield tr(
                    f"Another unit answers: {self._model()}. Everything from here on is its own.",
                    f"Отвечает другой блок: {self._model()}. Всё дальнейшее относится к нему.",
                )
            case ParameterDropped():
                yield tr(
                    f"The unit refuses {event.name}: left out, the others go on.",
                    f"Блок не знает {event.name}: он пропущен, остальные читаются дальше.",
                )
            case AlarmChanged():
                yield f"{'✓' if event.better else '▲'} {capital(localized(event.text))}."
            case MethodChosen() if self._verbose:
                yield from self._chose(event)
            case PlanChanged() if self._verbose:
                yield from self._planned(event.plan)

    def _came(self, event: Sampled) -> Iterator[str]:
        self._sampled = event.time
        if self._broken is not None:
            seconds = f"{max(0.0, event.time - self._broken):.0f}"
            yield tr(f"Back after {seconds} s.", f"Связь вернулась через {seconds} с.")
        self._broken = self._waiting = None

    def _lost(self, event: CycleFailed) -> Iterator[str]:
        """A cycle that failed is no news, unless it is one of many: then why is."""
        if isinstance(event.error, NoConnection | SyncLost) or self._waiting is LineState.SAMPLING:
            return  # the line's state tells it, or it was told
        since = max((it for it in (self._sampled, self._began) if it is not None), default=inf)
        if isinstance(event.error, EngineStopped) or event.time - since >= _LASTING:
            self._waiting = LineState.SAMPLING
            if self._broken is None:
                self._broken = event.time if self._sampled is None else self._sampled
            told = (
                f"{localized(event.error.reason)}.",
                localized(ADVICE.advice(event.error)),
                _waits(),
            )
            yield " ".join(sentence for sentence in told if sentence)

    def _planned(self, plan: Plan) -> Iterator[str]:
        self._plan = plan
        if self._session.asked.method == "auto" and plan.method != self._method:
            yield tr(
                "Methods are being tried, each for about a second; which one goes on is told then.",
                "Пробуем способы, каждый около секунды; потом скажем, какой останется.",
            )
        else:
            yield priced(plan)

    def _chose(self, event: MethodChosen) -> Iterator[str]:
        self._method = event.method
        yield chosen(event, self._session.asked.rate)
        if self._plan is not None and self._plan.method == event.method:
            yield priced(self._plan)  # it is not told anew

    def _state(self, event: StateChanged) -> Iterator[str]:
        well = event.state in (LineState.SAMPLING, LineState.ECU_ALIVE)
        if well:
            self._began = event.time
        if not well and self._session.connected:
            if self._broken is None:
                self._broken = event.time if self._sampled is None else self._sampled
            if event.state is not self._waiting:  # the same with another reason is no news
                yield waiting(event)
            self._waiting = event.state
            if self._verbose and event.error is not None:
                yield localized(ADVICE.text(event.error))

    def _model(self) -> str:
        model = self._session.model
        return localized(model.text) if model else "?"

    def _new_file(self, path: Path) -> None:
        self._tell(tr(f"The recording goes on in {path}.", f"Запись продолжается в {path}."))


def waiting(event: StateChanged) -> str:
    """The state in words, and that nobody need do anything in this window."""
    state = capital(localized(event.state.text))
    state += "" if state.endswith("?") else "."
    return f"{state} {_waits()}"


def _waits() -> str:
    return tr("Waiting; it goes on by itself.", "Ждём; опрос продолжится сам.")


def stopped(failure: MikasError) -> str:
    """That nothing more is recorded, and what of it is left."""
    why = localized(failure.reason)
    return tr(
        f"NOT RECORDING any more. {why}. Sampling goes on.",
        f"ЗАПИСЬ ПРЕКРАЩЕНА. {why}. Опрос идёт дальше.",
    )


def priced(plan: Plan) -> str:
    """What the plan in force costs a cycle."""
    price = plan.price()
    size, milliseconds = f"{price.bytes:.0f}", f"{price.seconds * 1000:.0f}"
    rate = decimal(f"{price.rate:.1f}")
    return tr(
        f"Plan: {plan.method}, {size} bytes and {milliseconds} ms a cycle, {rate} sets/s at best.",
        f"План: {plan.method}, байт на цикл {size}, {milliseconds} мс, не больше {rate} раз/с.",
    )


def chosen(event: MethodChosen, enough: float | None = None) -> str:
    """The method, and what each gave that was measured; a dash: it does not work.

    `enough`: the rate that is wanted, for which a slower one may have been taken.
    """
    rates = ", ".join(
        f"{name} {rate:.1f}" if rate else f"{name} –" for name, rate in event.rates.items()
    )
    if not rates:
        return tr(f"Method: {event.method}.", f"Способ: {event.method}.")
    why, ru_why = ".", "."
    if enough is not None and event.rates.get(event.method, 0.0) < max(event.rates.values()):
        wanted = f"{enough:g}"
        why = f": enough for the {wanted} asked for, and it does least to the unit."
        ru_why = f": для заданных {decimal(wanted)} хватает, а блок он нагружает меньше других."
    return tr(
        f"Method: {event.method} (sets/s: {rates}){why}",
        f"Способ: {event.method} (раз/с: {decimal(rates)}){ru_why}",
    )


def capital(text: str) -> str:
    """`text` with its first letter as at the beginning of a sentence."""
    return text[:1].upper() + text[1:]
