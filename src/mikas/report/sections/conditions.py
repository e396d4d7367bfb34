"""The conditions of the measurement, as rows of a name and a text."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import suppress
from typing import Final

from mikas.errors import UsageError
from mikas.i18n import Language, Text
from mikas.link.ports import described
from mikas.link.urls import parse
from mikas.recording.formatting import clock, duration, number
from mikas.report.findings import Findings
from mikas.report.labels import Labels
from mikas.report.sections.summary import idle_sentence
from mikas.sampling.events import Gap
from mikas.virtual.scenarios.scenario import DEFAULT, SCENARIOS

_METHODS: Final = {
    "single": Text("one request per parameter (61)", "запрос на каждый параметр (61)"),
    "batch": Text(
        "several parameters per request (61)", "несколько параметров одним запросом (61)"
    ),
    "list": Text("a list in the unit (64, 63)", "список в блоке (64, 63)"),
    "stream": Text("a stream from the unit (71)", "поток от блока (71)"),
}
_STROKE: Final = Text(
    "a response every engine cycle (7F–83)", "ответ на каждый рабочий цикл (7F–83)"
)
_MOST_LISTED: Final = 3
_SENTENCE_END: Final = re.compile(
    r" \((?:sent|received|послано|принято|не принято) |\.(?:\s|$)"
)  # a reason's first sentence: the bytes that were on the wire, or its end


def rows(found: Findings, language: Language) -> Iterator[tuple[str, str]]:
    """Yield the known conditions."""
    label, how, measured = Labels(language), found.subject.conditions, found.measured
    yield label("length"), duration(measured.seconds).to(language)
    rate = measured.rows / measured.seconds if measured.seconds else 0.0
    yield (
        label("samples"),
        label("sample_rate", count=measured.rows, rate=number(rate, 1, language)),
    )
    yield label("idle"), idle_sentence(found).to(language)
    if how.method:
        method = _method(how.method).to(language)
        others = label("other_methods") if how.other_methods else ""
        yield label("method"), "; ".join(filter(None, (method, others)))
    adapter = described(how.adapter).to(language)
    where = " · ".join(filter(None, (adapter, _port(how.port).to(language))))
    if where:
        yield label("adapter"), where
    if how.echo is not None:
        yield label("echo"), label("yes" if how.echo else "no")
    yield label("gaps"), _gaps(how.interruptions, measured.began or 0.0, label, language)
    if how.clock:
        yield label("clock"), _list([each.text.to(language) for each in how.clock], language)
    if how.errors is not None:
        yield label("errors"), label("since_connecting", count=how.errors)
    yield label("catalog"), found.subject.catalog.version


def _port(url: str) -> Text:
    """Return the URL; for a virtual car its scenario."""
    if not url.startswith("sim:"):
        return Text(url, url)
    with suppress(UsageError):
        scenario = SCENARIOS.get(parse(url).options.get("scenario", DEFAULT))
        if scenario is not None:
            return scenario.text
    return Text("a virtual car", "виртуальный автомобиль")


def _method(name: str) -> Text:
    """Return the method's text; for a method of a later version its name."""
    if name.startswith("stroke"):
        return _STROKE
    return _METHODS.get(name, Text(name, name))


def _gaps(pauses: tuple[Gap, ...] | None, began: float, label: Labels, language: Language) -> str:
    if pauses is None:
        return label("gaps_unknown")
    if not pauses:
        return label("gaps_none")
    texts = []
    for pause in pauses:
        ended = "…" if pause.ended is None else clock(pause.ended - began)
        why = ""
        if pause.reason is not None:
            why = f" ({_SENTENCE_END.split(pause.reason.to(language))[0]})"
        texts.append(f"{clock(pause.began - began)}–{ended}{why}")
    return f"{len(pauses)}: {_list(texts, language)}"


def _list(texts: list[str], language: Language) -> str:
    """Return the first texts, and how many follow."""
    more = len(texts) - _MOST_LISTED
    rest = Text(f"{more} more", f"ещё {more}").to(language) if more > 0 else ""
    return "; ".join(filter(None, (*texts[:_MOST_LISTED], rest)))
