"""`mikas causes`: the causes of a car's faults, ranked, from recordings or measured now."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from mikas.cli.click_extensions import argument, command, option
from mikas.cli.completion.values import RECORDING, files
from mikas.cli.context import CommandContext
from mikas.cli.language import capital, localized, tr
from mikas.cli.options.common import RELEARN
from mikas.cli.options.parameter_types import OneOf, existing_file, positive
from mikas.cli.options.sampling import SamplingOptions
from mikas.errors import usage_error
from mikas.json_values import picked

if TYPE_CHECKING:
    from mikas.causes.knowledge import Complaint, Knowledge
    from mikas.causes.result import Evidence, RankedCause, Ranking
    from mikas.recording.recording import Recording

COMPLAINTS: Final = (
    "idles-high", "hunts", "no-start", "no-power", "knocks", "overheats", "thirsty", "battery",
)  # fmt: skip
_SHOWN: Final = 3  # moments of an evidence


@command(
    en="Ranks what is wrong with a car, from its recordings (.pcapng) or, without FILE, from the "
    "connected car: measured until Ctrl-C or for --duration. Each cause comes with what speaks for "
    "and against it, and with the measurement that decides next. A start, some idle and a drive "
    "show most. The knowledge comes from a model of the engine and service literature, not from "
    "cars. Causes of your own: docs/reference/causes.md.",
    ru="Ищет причины неисправности по записям (.pcapng) одной машины, а без FILE — по подключённой "
    "машине: измерение до Ctrl-C или --duration. К каждой причине — что говорит за и против и "
    "какое измерение решит. Больше всего видно по пуску, холостому ходу и поездке. Знания — из "
    "модели двигателя и сервисной литературы, а не с машин. Свои причины: "
    "docs/ru/reference/causes.md.",
    examples=(
        "mikas causes drive.pcapng",
        "mikas causes drive.pcapng --complaint idles-high",
        "mikas causes --duration 180",
        "mikas causes drive.pcapng --json",
    ),
)
@argument("files", "[FILE]...", nargs=-1, type=existing_file, shell_complete=files(*RECORDING))
@option(
    "--complaint",
    type=OneOf(COMPLAINTS),
    metavar="WORD",
    en=f"the owner's complaint: {', '.join(COMPLAINTS)}",
    ru=f"жалоба владельца: {', '.join(COMPLAINTS)}",
)
@option(
    "--duration",
    type=positive,
    metavar="S",
    en="measure for so many seconds; not with FILE",
    ru="измерять столько секунд; без FILE",
)
@RELEARN
def causes(
    context: CommandContext,
    *,
    files: tuple[Path, ...],
    complaint: str | None,
    duration: float | None,
) -> None:
    if files and (duration is not None or context.capture or context.relearn):
        raise usage_error(
            "--duration, --capture and --relearn apply to measuring now; with FILE nothing is "
            "measured",
            "--duration, --capture и --relearn действуют при измерении; с FILE ничего не "
            "измеряется",
        )
    if files:
        from mikas.recording.recording import Recording

        _rank(context, [Recording(file, context.options.catalog) for file in files], complaint)
        return
    from mikas.cli.measuring import measured_now

    with measured_now(context, SamplingOptions(duration=duration)) as (recording, _):
        _rank(context, [recording], complaint, measured=True)


def _rank(
    context: CommandContext,
    recordings: Sequence[Recording],
    word: str | None,
    *,
    measured: bool = False,
) -> None:
    from mikas.causes.knowledge import Complaint, load
    from mikas.causes.recorded import rank_recordings
    from mikas.cli.config import own_causes

    knowledge = load(own_causes())
    for error in knowledge.errors:
        context.output.print_note(localized(error.reason))
    for recording in recordings:
        context.say_damaged(recording)
    complaint: Complaint | None = Complaint(word) if word else None
    ranking = rank_recordings(recordings, complaint=complaint, knowledge=knowledge)
    if context.output.json:
        _print_json(context, ranking, knowledge, [] if measured else recordings)
    else:
        _Page(context, recordings).show(ranking)


def _print_json(
    context: CommandContext,
    ranking: Ranking,
    knowledge: Knowledge,
    recordings: Sequence[Recording],
) -> None:
    files = [str(each.path) for each in recordings]
    errors = [picked(it, "file", "line", "problem") for it in knowledge.errors]
    context.output.data(ranking.as_json() | {"files": files, "errors": errors})


class _Page:
    """Prints a ranking for people."""

    def __init__(self, context: CommandContext, recordings: Sequence[Recording]) -> None:
        self._output = context.output
        self._names = [each.path.name for each in recordings]
        self._begins = [
            min((begin for begin, _ in each.raw.spans.values()), default=None)
            for each in recordings
        ]

    def show(self, ranking: Ranking) -> None:
        """Print the verdict, the causes, the next measurements, the missing and the doubts."""
        output = self._output
        output.paragraph(localized(ranking.text))
        for number, cause in enumerate(ranking.causes, 1):
            self._show_cause(number, cause)
        if ranking.next:
            output.line()
            output.line(tr("Measure next:", "Что измерить дальше:"))
        for each in ranking.next:
            command = f" (mikas test {each.test})" if each.guided else ""
            output.paragraph(f"{localized(each.text)}{command}", "  ")
            output.paragraph(localized(each.why), "    ")
            for outcome in each.outcomes:
                words = f"{localized(outcome.text)}: {localized(outcome.means)}"
                output.paragraph(words, "    - ")
        output.line()
        if ranking.not_seen:
            missing = ", ".join(map(localized, ranking.not_seen))
            output.paragraph(tr(f"Not seen: {missing}.", f"Не видно: {missing}."))
        for doubt in ranking.doubts:
            output.paragraph(localized(doubt))

    def _show_cause(self, number: int, cause: RankedCause) -> None:
        from mikas.causes.result import LIKELIHOODS

        output = self._output
        likely = capital(localized(LIKELIHOODS[cause.likelihood]))
        output.line()
        output.paragraph(f"{likely}: {localized(cause.text)}", f"{number}. ")
        rows = [["  +", *self._cells(each)] for each in cause.evidence_for]
        rows += [["  −", *self._cells(each)] for each in cause.evidence_against]
        if rows:
            output.table([], rows)
        output.paragraph(f"{tr('Check', 'Проверить')}: {localized(cause.check)}", "   ")

    def _cells(self, evidence: Evidence) -> list[str]:
        return [localized(evidence.text), self._moments(evidence)]

    def _moments(self, evidence: Evidence) -> str:
        from mikas.recording.formatting import between

        began = self._begins[evidence.source]
        longest = sorted(evidence.spans, key=lambda span: span[0] - span[1])[:_SHOWN]
        words = [localized(between(first, last, began)) for first, last in sorted(longest)]
        rest = len(evidence.spans) - len(words)
        more = tr(f" and {rest} more", f" и ещё {rest}") if rest else ""
        file = f"{self._names[evidence.source]}: " if len(self._names) > 1 else ""
        return f"{file}{'; '.join(words)}{more}" if words else ""
