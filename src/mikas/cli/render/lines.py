"""Samples as lines: JSON, or cells separated by tabs. A value that is not new is null or a dash."""

from __future__ import annotations

from types import TracebackType
from typing import TYPE_CHECKING, Protocol, Self

from mikas.cli.language import decimal, tr
from mikas.cli.render.output import Output
from mikas.cli.render.readings import shown_value
from mikas.sampling.events import CycleFailed, Sampled

if TYPE_CHECKING:
    from mikas.cli.sampling_run import SamplingRun
    from mikas.client import Reading
    from mikas.sampling.derived import DerivedValue
    from mikas.sampling.events import Event


class Display(Protocol):
    """Where a sampling run is shown."""

    def take(self, event: Event) -> None:
        """Show `event` now."""

    def tell(self, sentence: str) -> None:
        """Show a notice."""

    def __enter__(self) -> Self: ...

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None: ...


class _Lines:
    """The common part of both kinds of lines: notices on stderr."""

    def __init__(self, session: SamplingRun, output: Output) -> None:
        self._channels = session.channels
        self._output = output

    def tell(self, sentence: str) -> None:
        self._output.note(sentence)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        return None


class JsonLines(_Lines):
    """`{"time", "values", "gap"}`, one a cycle; in a gap one a try, with its `reason`."""

    def take(self, event: Event) -> None:
        if not isinstance(event, Sampled | CycleFailed):
            return
        fresh = fresh_in(event)
        values = {c.name: fresh[c.name].value if c.name in fresh else None for c in self._channels}
        time = round(event.time, 6)
        line: dict[str, object] = {
            "time": time,
            "values": values,
            "gap": isinstance(event, CycleFailed),
        }
        if isinstance(event, CycleFailed):
            line["reason"] = {"en": event.error.reason.en, "ru": event.error.reason.ru}
        self._output.data(line)


class PlainLines(_Lines):
    """One line per sample, after a heading."""

    def __init__(self, session: SamplingRun, output: Output) -> None:
        super().__init__(session, output)
        self._begun = False

    def take(self, event: Event) -> None:
        if not isinstance(event, Sampled | CycleFailed):
            return
        if not self._begun:  # not before there is something: an error needs no heading
            self._begun = True
            names = (channel.name for channel in self._channels)
            self._output.line("\t".join([tr("time", "время"), *names]))
        fresh = fresh_in(event)
        cells = (
            shown_value(fresh[channel.name]) if channel.name in fresh else "–"
            for channel in self._channels
        )
        self._output.line("\t".join([decimal(f"{event.time:.3f}"), *cells]))


def fresh_in(event: Sampled | CycleFailed) -> dict[str, Reading | DerivedValue]:
    """Return the values read in this cycle, by name; none in a gap."""
    return {**event.fresh, **event.derived} if isinstance(event, Sampled) else {}
