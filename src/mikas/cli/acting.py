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

from mikas.catalog import Catalog
from mikas.cli.context import CommandContext
from mikas.cli.language import decimal, localized, tr
from mikas.cli.options.sampling import SamplingOptions
from mikas.cli.render.terminal import ring
from mikas.cli.sampling_run import SamplingRun
from mikas.conditions import ConditionWatch, Fired, LoadedActions, load_actions
from mikas.conditions.performing import ActionRunner, Hands, lacking
from mikas.i18n import Text
from mikas.sampling.events import Event

Follow = Callable[[Event], None]


def nothing(event: Event) -> None:
    """Follow an event of a run without actions."""


def load(
    context: CommandContext, file: Path, options: SamplingOptions
) -> tuple[LoadedActions, SamplingOptions]:
    """Return the actions of `file`, and options that also sample what their conditions need."""
    catalog = context.options.catalog
    actions = load_actions(file, catalog)
    needed = ConditionWatch(actions.rules, catalog).requires
    return actions, replace(options, names=_with(options.names, needed, catalog))


def _with(names: Sequence[str], needed: tuple[str, ...], catalog: Catalog) -> tuple[str, ...]:
    """Return `names` with those that are `needed` besides; no name stands for all parameters."""
    if not names:
        return ()
    channels = [catalog.channel(name.partition("/")[0]).name for name in names]
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
    watch = ConditionWatch(actions.rules, context.options.catalog)
    failed = partial(_say, show)
    with ActionRunner(actions, context.options.catalog, hands, failed, lambda: run.later) as runner:

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
