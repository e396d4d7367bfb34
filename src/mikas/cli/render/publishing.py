"""What `mikas publish` says of the broker: sentences and a status line, or JSON lines."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any

from mikas.cli.advice import ADVICE
from mikas.cli.language import capital, decimal, localized, tr
from mikas.cli.render.output import Output, StatusLine
from mikas.i18n import plural
from mikas.sampling.events import Event, StateChanged

if TYPE_CHECKING:
    from mikas.cli.sampling_run import SamplingRun
    from mikas.publish.connection import BrokerChange
    from mikas.publish.outbox import Lost
    from mikas.publish.session import Publisher


class PublishingReport:
    """Reports on the connection `url`, from any thread; `run` is the run that is published.

    With JSON, a line for each change of the broker and of the unit's line.
    """

    def __init__(self, output: Output, run: SamplingRun, url: str, base: str) -> None:
        self.publisher: Publisher | None = None
        self.progress: StatusLine = StatusLine(output, self._status)
        self._output = output
        self._run = run
        self._url = url
        self._base = base
        self._writing = threading.Lock()
        self._was_connected = False

    def print_notice(self, sentence: str) -> None:
        """Print a sentence above the status line."""
        with self._writing:
            self.progress.print_notice(sentence)

    def add_event(self, event: Event) -> None:
        """Follow an event of sampling."""
        if isinstance(event, StateChanged) and self._output.json:
            self._data("line", event.as_json() | {"time": round(event.time + self._run.later, 6)})
        self.progress.draw(event.time)

    def broker_changed(self, change: BrokerChange) -> None:
        """Say that the broker is reached, or why it is not."""
        if self._output.json:
            reason = None if change.error is None else change.error.reason._asdict()
            content = {
                "connected": change.is_connected,
                "reason": reason,
                "lost": _json(change.lost),
            }
            self._data("broker", content)
        self.print_notice(self._sentence(change))
        self._was_connected |= change.is_connected

    def _sentence(self, change: BrokerChange) -> str:
        if change.error is not None:
            waits = tr("Sampling continues; trying again.", "Опрос продолжается; пробуем ещё.")
            return f"{localized(ADVICE.text(change.error))} {waits}"
        if not self._was_connected:
            return tr(
                f"Publishing to {self._url} under {self._base}.",
                f"Публикация: {self._url}, тема {self._base}.",
            )
        back = tr("The broker is back.", "Брокер снова на связи.")
        return f"{back} {_lost_sentence(change.lost)}" if change.lost else back

    def print_last_line(self) -> None:
        """Print the last line: what was published, and what was not."""
        self.progress.clear()
        if self.publisher is None or not self._was_connected:
            return
        unsent = self.publisher.unsent
        if self._output.json:
            content = {
                "published": self.publisher.connection.sent,
                "samples": self._run.samples,
                "unsent": _json(unsent),
            }
            self._data("end", content)
        self._output.print_note(self._counts(self.publisher.connection.sent))
        if unsent:
            self._output.print_note(_lost_sentence(unsent))

    def _data(self, kind: str, content: dict[str, Any]) -> None:
        with self._writing:
            self._output.data({**content, "kind": kind})

    def _status(self) -> str:
        if self.publisher is None:
            return ""
        connection, waiting = self.publisher.connection, self._run.waiting
        lost = self._was_connected and not connection.is_connected
        parts = [
            tr("NO BROKER", "НЕТ БРОКЕРА") if lost else "",
            capital(localized(waiting.text)) if waiting is not None else "",
            self._counts(connection.sent),
        ]
        return " · ".join(filter(None, parts))

    def _counts(self, sent: int) -> str:
        run = self._run
        rate, gaps = f"{run.rate:.1f}", run.gap_cycles
        return tr(
            f"{self._url}: {plural(sent, 'message', 'messages')}, "
            f"{plural(run.samples, 'sample', 'samples')}, {rate} readings/s, "
            f"{plural(gaps, 'failed cycle', 'failed cycles')}",
            f"{self._url}: сообщений: {sent}, замеров: {run.samples}, {decimal(rate)} опр/с, "
            f"неудачных циклов: {gaps}",
        )


def _json(lost: Lost) -> dict[str, int]:
    return {"samples": lost.samples, "events": lost.events}


def _lost_sentence(lost: Lost) -> str:
    span = f"{(lost.until or 0) - (lost.since or 0):.0f}"
    return tr(
        f"It has not got {plural(lost.samples, 'sample', 'samples')} and "
        f"{plural(lost.events, 'event', 'events')}, of {span} s in all.",
        f"Он не получил замеров: {lost.samples}, событий: {lost.events}, всего за {span} с.",
    )
