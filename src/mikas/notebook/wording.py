"""An overview in words: a title, facts, lists and the table of channels, in one language.

`html` and `text` only lay it out. Texts are as they were recorded, so each is escaped there.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from mikas.cleaning import clean_line
from mikas.i18n import Language, Text, counted
from mikas.notebook.overview import ChannelOverview, Curve, Overview
from mikas.recording.formatting import CONFIDENCE, date_of, duration, number, percent
from mikas.recording.summary import Summary
from mikas.sampling.events import Gap

if TYPE_CHECKING:
    from mikas.catalog import Catalog
    from mikas.recording.recording import Recording

_MOST: Final = 12  # lines of a list
_FACTS: Final = {
    "car": Text("Car", "Машина"),
    "unit": Text("Control unit", "Блок управления"),
    "program": Text("Program", "Программа"),
    "data": Text("Calibration", "Калибровка"),
    "recorded": Text("Recorded", "Записано"),
    "length": Text("Length", "Длительность"),
    "by": Text("Adapter", "Адаптер"),
    "note": Text("Comment", "Комментарий"),
    "interpretation": Text("Interpretation", "Толкование"),
}
_LISTS: Final = {
    "faults": Text("Stored faults", "Ошибки в памяти блока"),
    "gone": Text("No longer stored", "Уже не в памяти"),
    "gaps": Text("Gaps", "Пропуски"),
    "markers": Text("Markers", "Отметки"),
    "problems": Text("Damage in the file", "Повреждения файла"),
}
HEADINGS: Final = (
    Text("Channel", "Параметр"),
    Text("", ""),
    Text("Unit", "Ед."),
    Text("Least", "Мин."),
    Text("Most", "Макс."),
    Text("Values/s", "Знач./с"),
)
COURSE: Final = Text("Course", "Ход")
_NOT_REPORTED: Final = Text("not reported", "не сообщает")
_NOT_READ: Final = Text("not read in this recording", "в этой записи не считывались")
_NONE: Final = Text("none", "нет")
_NO_NAME: Final = Text("no name", "без названия")
_UNKNOWN: Final = Text("unknown number", "неизвестный номер")
_CHECK: Final = Text("Check: {check}", "Проверить: {check}")
_NEW: Final = Text("new in this recording", "новая в этой записи")
_TO_THE_END: Final = Text("to the end", "до конца")
_NO_DATE: Final = Text("date unknown", "дата неизвестна")
_NO_VALUES: Final = Text("no values", "нет значений")
_ON: Final = Text("on in {share}", "вкл. {share}")
_SECONDS: Final = Text("s", "с")
_MORE: Final = Text("… and {count} more", "… и ещё {count}")
_IN_ALL: Final = Text("{count}, {length} in all", "{count}, всего {length}")


@dataclass(frozen=True, slots=True)
class List:
    """A list of lines. `more`: that there are more lines than these; empty: there are not."""

    title: str
    lines: Sequence[str]
    more: str = ""


@dataclass(frozen=True, slots=True)
class ChannelLine:
    """A line of the table of channels: its cells as in `HEADINGS`, and its course."""

    cells: tuple[str, ...]
    curve: Curve


@dataclass(frozen=True, slots=True)
class Wording:
    """All texts of an overview."""

    language: Language
    title: str
    facts: Sequence[tuple[str, str]]
    lists: Sequence[List]
    headings: tuple[str, ...]
    rows: Sequence[ChannelLine]


def worded(recording: Recording, overview: Overview, language: Language) -> Wording:
    """Return the overview in words."""
    words = _Words(overview, recording.catalog, language)
    lists = [words.faults(), words.gone(), words.gaps(), words.markers(), words.problems(recording)]
    return Wording(
        language,
        clean_line(recording.path.name),
        [(_FACTS[key].to(language), text) for key, text in words.facts(recording) if text],
        [each for each in lists if each is not None],
        tuple(heading.to(language) for heading in HEADINGS),
        [words.row(each) for each in overview.channels],
    )


class _Words:
    def __init__(self, overview: Overview, catalog: Catalog, language: Language) -> None:
        self._overview, self._catalog, self._language = overview, catalog, language

    def _to(self, text: Text) -> str:
        return text.to(self._language)

    def facts(self, recording: Recording) -> Iterator[tuple[str, str]]:
        summary, about = self._overview.summary, recording.about
        yield "car", summary.car.name
        yield "unit", self._to(summary.model) if summary.model else about.get("unit", "")
        if summary.passport is not None:
            yield "program", self._pieces(summary.passport[:3])
            yield "data", self._pieces(summary.passport[3:])
        date = date_of(summary.first)
        yield "recorded", f"{date:%d.%m.%Y %H:%M}" if date else self._to(_NO_DATE)
        yield "length", self._length(summary)
        yield "by", about.get("adapter") or about.get("port", "")
        yield "note", summary.note
        if recording.interpretation != "corrected":
            yield "interpretation", recording.interpretation

    def _pieces(self, pieces: Iterable[str | None]) -> str:
        shown = " · ".join(piece.strip() for piece in pieces if piece and piece.strip())
        return shown or self._to(_NOT_REPORTED)

    def _length(self, summary: Summary) -> str:
        responses = counted(
            self._overview.rows, ("response", "responses"), ("ответ", "ответа", "ответов")
        )
        parts = [self._to(responses)]
        if summary.length is not None:
            parts.insert(0, self._to(duration(summary.length)))
        if summary.recordings > 1:
            sessions = counted(
                summary.recordings, ("session", "sessions"), ("сеанс", "сеанса", "сеансов")
            )
            parts.append(self._to(sessions))
        return ", ".join(parts)

    def faults(self) -> List:
        readings = self._overview.faults.readings
        title = self._to(_LISTS["faults"])
        if not readings:
            return List(title, [self._to(_NOT_READ)])
        new = {fault.code for fault in self._overview.faults.appeared}
        lines = [self._fault(code, is_new=code in new) for code in readings[-1].codes]
        return self._list(title, lines) if lines else List(title, [self._to(_NONE)])

    def _fault(self, code: int, *, is_new: bool) -> str:
        fault = self._catalog.fault(code)
        parts = [self._to(fault.text) or self._to(_UNKNOWN)]
        if fault.known and not fault.informational:
            parts.append(self._to(CONFIDENCE[fault.confidence]))
        if is_new:
            parts.append(self._to(_NEW))
        check = self._to(fault.check)
        return f"{code} – {'; '.join(parts)}" + (
            f". {self._to(_CHECK.filled(check=check))}" if check else ""
        )

    def gone(self) -> List | None:
        readings = self._overview.faults.readings
        now = set(readings[-1].codes) if readings else set()
        before = dict.fromkeys(code for reading in readings for code in reading.codes)
        codes = [str(code) for code in before if code not in now]
        return self._list(self._to(_LISTS["gone"]), [", ".join(codes)]) if codes else None

    def gaps(self) -> List:
        gaps = self._overview.gaps
        title = self._to(_LISTS["gaps"])
        if not gaps:
            return List(title, [self._to(_NONE)])
        known = sum(gap.ended - gap.began for gap, _ in gaps if gap.ended is not None)
        in_all = _IN_ALL.filled(count=len(gaps), length=duration(known))
        lines = [self._gap(*each) for each in gaps[:_MOST]]
        return self._list(f"{title}: {self._to(in_all)}", lines, len(gaps))

    def _gap(self, gap: Gap, reason: Text | None) -> str:
        length = _TO_THE_END if gap.ended is None else duration(gap.ended - gap.began)
        because = f": {self._to(reason)}" if reason else ""
        return f"{self._moment(gap.began)}, {self._to(length)}{because}"

    def markers(self) -> List | None:
        markers = self._overview.markers
        lines = [
            f"{self._moment(each.time)}: {each.label or self._to(_NO_NAME)}"
            for each in markers[:_MOST]
        ]
        return self._list(self._to(_LISTS["markers"]), lines, len(markers)) if markers else None

    def problems(self, recording: Recording) -> List | None:
        count = recording.problem_count
        lines = [
            f"{problem.offset}: {self._to(problem.text)}" for problem in recording.problems[:_MOST]
        ]
        return self._list(self._to(_LISTS["problems"]), lines, count) if count else None

    def _list(self, title: str, lines: Sequence[str], count: int | None = None) -> List:
        more = (len(lines) if count is None else count) - min(len(lines), _MOST)
        return List(title, lines[:_MOST], self._to(_MORE.filled(count=more)) if more else "")

    def _moment(self, time: float) -> str:
        """Return seconds from the first row, as tables count them, and the time of day."""
        date = date_of(time)
        since = f"{number(time - self._overview.zero, 1, self._language)} {self._to(_SECONDS)}"
        return f"{since} ({date:%H:%M:%S})" if date else since

    def row(self, each: ChannelOverview) -> ChannelLine:
        channel, language = each.channel, self._language
        known = self._catalog.described(channel.name)
        has_text = known is not None and known.unit == channel.unit
        unit = known.unit_text.to(language) if known and has_text else channel.unit_in(language)
        least, most = (self._value(each, value) for value in (each.least, each.most))
        if not each.count:
            least, most = self._to(_NO_VALUES), ""
        elif each.share is not None:
            least, most = self._to(_ON.filled(share=percent(each.share))), ""
        rate = "" if each.rate is None else number(each.rate, 1 if each.rate < 10 else 0, language)
        name = f"{channel.name} ƒ" if each.is_derived else channel.name
        return ChannelLine((name, self._to(channel.text), unit, least, most, rate), each.curve)

    def _value(self, each: ChannelOverview, value: float | None) -> str:
        return "" if value is None else number(value, each.channel.decimals, self._language)
