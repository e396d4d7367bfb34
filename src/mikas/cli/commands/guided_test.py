"""`mikas test`: a guided test on the terminal, or over a recording."""

from __future__ import annotations

from contextlib import ExitStack, closing
from pathlib import Path
from typing import TYPE_CHECKING, Final

from mikas.catalog.conversion import NO_TEXT
from mikas.cli.click_extensions import argument, command, option
from mikas.cli.completion.values import RECORDING, files, guided_tests, steps_of_test
from mikas.cli.context import CommandContext
from mikas.cli.language import localized, tr
from mikas.cli.options.parameter_types import existing_file, positive
from mikas.cli.options.sampling import INSTRUMENTS, SamplingOptions
from mikas.errors import UsageError, usage_error
from mikas.i18n import Text, joined
from mikas.json_values import picked
from mikas.options import nearest

if TYPE_CHECKING:
    from mikas.cli.port_ahead import PortAhead
    from mikas.guided.definition import GuidedTest
    from mikas.guided.engine import Progress, TestEngine
    from mikas.guided.loading import LoadedTests
    from mikas.guided.result import TestResult


@command(
    en="Leads through the guided test NAME step by step, and ends with a verdict, its rule, its "
    "doubt, and what to check next; without NAME, lists the tests. Only values are read. "
    "With --recording the test is done over FILE, if its steps are found there.",
    ru="Проводит проверку NAME по шагам и заканчивает заключением: правило, сомнения, что "
    "проверить дальше; без NAME — список проверок. Значения только читаются. С --recording "
    "проверка идёт по записи FILE, если в ней есть нужные шаги.",
    examples=(
        "mikas test",
        "mikas test charging",
        "mikas test idle --json",
        "mikas test sensors --recording drive.pcapng",
    ),
)
@argument("name", "[NAME]", required=False, shell_complete=guided_tests)
@option(
    "--skip",
    multiple=True,
    metavar="STEP",
    shell_complete=steps_of_test,
    en="skip this step (more than once for several); without its numbers nothing is good",
    ru="пропустить этот шаг (можно несколько раз); без его чисел ничего не «в порядке»",
)
@option(
    "--recording",
    type=existing_file,
    shell_complete=files(*RECORDING),
    en="do the test over a recording (needs no port)",
    ru="по записи (порт не нужен)",
)
@INSTRUMENTS
@option(
    "--duration",
    type=positive,
    metavar="S",
    en="end after S seconds without a verdict",
    ru="закончить через S секунд без заключения",
)
def test(
    context: CommandContext,
    *,
    name: str | None,
    skip: tuple[str, ...],
    recording: Path | None,
    instruments: tuple[str, ...],
    duration: float | None,
) -> None:
    from mikas.cli.config import own_tests
    from mikas.guided.loading import load
    from mikas.instruments.choosing import chosen_instruments

    catalog = context.options.catalog
    beside = chosen_instruments(instruments, catalog)
    formulas = catalog.with_beside(channel for each in beside for channel in each.channels)
    recorded = None
    if recording is not None:
        from mikas.recording.recording import Recording

        recorded = Recording(recording, catalog)
        formulas = recorded.formula_catalog
    loaded = load(catalog, own_tests(), formulas)
    for error in loaded.errors:
        context.output.print_note(localized(error.reason))
    if name is None:
        _list(context, loaded)
        return
    chosen = _chosen(loaded, name, skip)
    if recorded is not None:
        from mikas.guided.recorded import run_over

        _show(context, chosen, run_over(chosen, recorded, skip))
        return
    for each in chosen.beside:
        if each not in formulas.beside:
            raise _no_instrument(chosen, each)
    with context.open_ahead() as ahead:
        from mikas.guided.engine import TestEngine  # while the port opens

        engine = TestEngine(chosen, formulas)
        run = _guide(context, engine, ahead, skip, duration, instruments)
        _show(context, chosen, run)


def _no_instrument(chosen: GuidedTest, name: str) -> UsageError:
    return usage_error(
        f"the test {chosen.name} needs {name}, which no instrument of this run gives; add one, as "
        "in --instrument aem=/dev/ttyUSB1",
        f"проверке {chosen.name} нужен {name}, а прибора, который его даёт, нет; добавьте его, "
        "например --instrument aem=/dev/ttyUSB1",
    )


def _chosen(loaded: LoadedTests, name: str, skip: tuple[str, ...]) -> GuidedTest:
    found = loaded.tests.get(name)
    if found is None:
        known = ", ".join(nearest(name, loaded.tests) or loaded.tests)
        raise usage_error(
            f"there is no test “{name}”; there is: {known}",
            f"нет проверки «{name}»; есть: {known}",
        )
    steps = [step.name for step in found.steps]
    for each in skip:
        if each not in steps:
            raise usage_error(
                f"{name} has no step “{each}”; its steps: {', '.join(steps)}",
                f"в проверке {name} нет шага «{each}»; её шаги: {', '.join(steps)}",
            )
    return found


def _list(context: CommandContext, loaded: LoadedTests) -> None:
    tests = list(loaded.tests.values())
    if context.output.json:
        context.output.data(
            {
                "tests": [
                    picked(it, "name", "title", "finds", "minutes")
                    | {"steps": [step.name for step in it.steps], "own": it.own}
                    for it in tests
                ],
                "errors": [picked(it, "file", "line", "problem") for it in loaded.errors],
            }
        )
        return
    rows = [[it.name, localized(it.title), localized(it.finds)] for it in tests]
    context.output.table(["NAME", tr("test", "проверка"), tr("finds", "находит")], rows)


def _guide(
    context: CommandContext,
    engine: TestEngine,
    ahead: PortAhead,
    skip: tuple[str, ...],
    duration: float | None,
    instruments: tuple[str, ...],
) -> TestResult | Text:
    """Return the result; an empty text, if the test did not come to its end."""
    from mikas.cli.render.notices import Notices
    from mikas.cli.sampling_run import sampling_session
    from mikas.client.parameters.derived import number_of
    from mikas.sampling.events import Sampled

    output, chosen = context.output, engine.test
    options = SamplingOptions(names=chosen.channels, duration=duration)
    said: tuple[int | None, bool] | None = None
    waiting = _Waiting()
    with ExitStack() as stack:
        run = stack.enter_context(
            sampling_session(
                context, options, ahead, context.capture, joined=False, instruments=instruments
            )
        )
        notices = Notices(run, output.print_note, verbose=output.verbose)
        for event in stack.enter_context(closing(notices.watch())):
            if not isinstance(event, Sampled):
                continue
            row = {name: number_of(it) for name, it in event.fresh.items()}
            row |= {name: it.value for name, it in event.instruments.items()}
            engine.add_row(event.time, row)
            engine.skip_all(skip)
            if engine.result is not None:
                break
            progress = engine.progress()
            if (now := (progress.step, progress.late)) != said:
                is_new = said is None or said[0] != progress.step
                # on stderr, so that stdout has the result alone
                if text := _instruction(chosen, progress.step, is_new=is_new):
                    output.print_note(text)
                said = now
            if text := waiting.sentence(progress, event.time):
                output.print_note(text)
    run.session.conclude()  # a date that was set just now
    if engine.result:
        return engine.result.moved(run.later)
    unmet = [it.text for it in engine.progress().unmet]
    return joined("; ", unmet) if unmet else NO_TEXT


class _Waiting:
    """Reports what keeps a test waiting: after some seconds, at each change, and now and then."""

    def __init__(self) -> None:
        self._said: tuple[object, ...] | None = None
        self._said_at = 0.0

    def sentence(self, progress: Progress, now: float) -> str:
        """Return the conditions that do not hold, with value and limit; empty if not due."""
        if not progress.unmet or progress.seconds < _PATIENCE:
            return ""
        waits = (progress.step, *(it.name for it in progress.unmet))
        if waits == self._said and now - self._said_at < _REPEATED:
            return ""
        self._said, self._said_at = waits, now
        return tr("waiting: ", "ожидание: ") + "; ".join(
            localized(it.text) for it in progress.unmet
        )


_PATIENCE: Final = 3.0  # s
_REPEATED: Final = 20.0  # s


def _instruction(test: GuidedTest, step: int | None, *, is_new: bool) -> str:
    """Return what to do in `step`; of one that is late its advice, empty without one."""
    if step is None:
        return localized(test.needs)
    if is_new:
        return f"{step + 1}/{len(test.steps)}. {localized(test.steps[step].text)}"
    return localized(test.steps[step].advice)


def _show(context: CommandContext, chosen: GuidedTest, found: TestResult | Text) -> None:
    """Print the result, or that there is none and why."""
    result = None if isinstance(found, Text) else found
    if context.output.json:
        content = result and result.as_json() | {"verdict": result.verdict._asdict()}
        context.output.data({"test": chosen.name, "result": content})
    elif result is not None:
        for line in localized(result.as_text()).split("\n"):
            context.output.line(line)
    if isinstance(found, Text):
        context.say(
            f"{chosen.name}: the test did not come to its end, so there is no verdict"
            + (f": {found.en}" if found.en else "."),
            f"{chosen.name}: проверка не дошла до конца, заключения нет"
            + (f": {found.ru}" if found.ru else "."),
        )
