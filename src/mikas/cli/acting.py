"""Actions on conditions in a run of `watch` or `log`: the rules of a file, followed and done.

The file is read before the port is opened, so that a mistake in it is said at once. A rule that
this command can't do as a whole is named once, at the begin.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path

from mikas.catalog import Catalog, InstrumentChannel
from mikas.cli.context import CommandContext
from mikas.cli.language import decimal, localized, tr
from mikas.cli.options.sampling import SamplingOptions
from mikas.cli.render.terminal import ring
from mikas.cli.sampling_run import SamplingRun
from mikas.conditions import ActionRule, ConditionWatch, Fired, LoadedActions, load_actions
from mikas.conditions.performing import ActionRunner, Hands, lacking
from mikas.errors import UsageError, usage_error
from mikas.i18n import Text
from mikas.instruments.choosing import chosen_instruments
from mikas.sampling.events import Event

Follow = Callable[[Event], None]


def nothing(event: Event) -> None:
    """Follow an event of a run without actions."""


def load(
    context: CommandContext, file: Path, options: SamplingOptions, instruments: Sequence[str]
) -> tuple[LoadedActions, SamplingOptions]:
    """Return the actions of `file`, and options that also sample what their conditions need.

    Raises `UsageError` for an action that needs an instrument which the run does not have.
    """
    catalog = context.options.catalog
    chosen = chosen_instruments(instruments, catalog)
    catalog = catalog.with_beside(channel for each in chosen for channel in each.channels)
    actions = load_actions(file, catalog)
    for rule in actions.rules:
        for name in catalog.required_beside(rule.channels):
            if name not in catalog.beside:
                raise _no_instrument(rule, name)
    needed = ConditionWatch(actions.rules, catalog).requires
    return actions, replace(options, names=_with(options.names, needed, catalog))


def _no_instrument(rule: ActionRule, name: str) -> UsageError:
    return usage_error(
        f"Action {rule.name}: “{rule.when}” needs {name}, which no instrument of this run gives; "
        "add one, as in --instrument aem=/dev/ttyUSB1",
        f"Действие {rule.name}: для «{rule.when}» нужен {name}, а прибора, который его даёт, нет; "
        "добавьте его, например --instrument aem=/dev/ttyUSB1",
    )


def _with(names: Sequence[str], needed: tuple[str, ...], catalog: Catalog) -> tuple[str, ...]:
    """Return `names` with those that are `needed` besides; no name stands for all parameters."""
    if not names:
        return ()
    channels = [catalog.formula_channel(name.partition("/")[0]).name for name in names]
    sampled = set(catalog.required_by([name for name in channels if name in catalog.channels]))
    return (*names, *(name for name in needed if name not in sampled))


@contextmanager
def acting(
    context: CommandContext,
    run: SamplingRun,
    actions: LoadedActions | None,
    show: Callable[[str], None],
    *,
    marks: bool,
    stops: bool,
) -> Iterator[Follow]:
    """Yield the function that follows the run's events, and does what the rules say.

    `marks`: the run has a file for markers. `stops`: an action may end it.
    """
    if actions is None:
        yield nothing
        return

    def stop() -> None:
        show(tr("An action ends the recording.", "Действие завершает запись."))
        run.live.stop()

    def mark(text: Text) -> None:
        run.recorder.marker(label=localized(text))

    hands = Hands(mark=mark if marks else None, stop=stop if stops else None, sound=ring)
    for name, key in lacking(actions.rules, hands):
        show(
            tr(
                f"Action {name}: {key} is not done by this command.",
                f"Действие {name}: эта команда не выполняет {key}.",
            )
        )
    beside = (each for each in run.channels if isinstance(each, InstrumentChannel))
    catalog = context.options.catalog.with_beside(beside)
    watch = ConditionWatch(actions.rules, catalog)
    failed = partial(_say, show)
    with ActionRunner(actions, catalog, hands, failed, lambda: run.later) as runner:

        def follow(event: Event) -> None:
            for fired in watch.follow(event):
                show(_sentence(fired))
                runner.perform(fired)

        yield follow


def _say(show: Callable[[str], None], failure: Text) -> None:
    show(localized(failure))


def _sentence(fired: Fired) -> str:
    seconds = decimal(f"{fired.time - fired.since:.1f}")
    rule = fired.rule
    return tr(
        f"◆ {rule.name}: {rule.when}, for {seconds} s.",
        f"◆ {rule.name}: {rule.when}, уже {seconds} с.",
    )
