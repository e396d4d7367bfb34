"""Write docs/development/causes.md and its Russian twin: how often the ranking is right."""

from __future__ import annotations

import tomllib
from collections import Counter
from collections.abc import Sequence
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Final

from mikas.causes.knowledge import load
from mikas.causes.weights import shipped
from mikas.i18n import Language, Text
from tools.causes.cars import BY_NAME
from tools.causes.measure import (
    Measured,
    Outcome,
    confusion,
    found,
    is_wrong,
    reliability,
    share,
    smallest,
)

DOCS: Final = Path(__file__).parents[2] / "docs"

_BARS: Final = "▁▂▃▄▅▆▇█"
_FOLDERS: Final[dict[Language, Path]] = {"en": DOCS, "ru": DOCS / "ru"}
_VERDICTS: Final = {
    "sound": Text("sound", "исправна"),
    "cannot-tell": Text("can't tell", "сказать нельзя"),
    "unknown": Text("unknown", "неизвестно"),
    "causes": Text("a neighbour", "соседняя"),
}


@cache
def _texts() -> dict[str, Text]:
    tables = tomllib.loads(Path(__file__).with_name("page.toml").read_text("utf-8"))
    return {name: Text(both["en"].strip(), both["ru"].strip()) for name, both in tables.items()}


def write(measured: Measured) -> None:
    """Write both pages."""
    for language, folder in _FOLDERS.items():
        path = folder / "development" / "causes.md"
        path.write_text(page(measured, language), "utf-8")


def page(measured: Measured, language: Language) -> str:
    """Return the page in one language."""
    header = shipped().header[-1].partition(": ")[2].rstrip(".")
    if language == "ru":
        numbers = [word for word in header.replace(",", "").split() if word.isdigit()]
        header = f"{numbers[0]}, исправных — {numbers[1]}"
    date = f"{datetime.now(UTC):%Y-%m-%d}"
    constants = shipped().constants
    head = (
        _texts()["head"]
        .to(language)
        .format(
            date=date,
            about=header,
            certain=f"{100 * constants.certain:g}",
            cleared=f"{100 * constants.cleared:g}",
        )
    )
    each = len(measured.noticeable) // len(BY_NAME)
    parts = [
        head.rstrip(),
        _texts()["confusion"].to(language).format(cars=each),
        _confusion(measured.noticeable, language),
        _texts()["reliability"].to(language),
        _reliability([*measured.noticeable, *measured.half, *measured.sound], language),
        _texts()["amounts"].to(language),
        _amounts(measured, language),
        _not_driven(measured, language),
        _several(measured, language),
    ]
    return "\n\n".join(parts) + "\n"


def _words(name: str, language: Language) -> str:
    causes = load().causes
    return causes[name].text.to(language) if name in causes else name


def _said(what: str, language: Language) -> str:
    return _VERDICTS[what].to(language) if what in _VERDICTS else what


def _confusion(rows: Sequence[Outcome], language: Language) -> str:
    lines = [_texts()["confusion_head"].to(language)]
    for name, counts in confusion(rows).items():
        mine = [row for row in rows if name in row.car.defects]
        right = name.partition("-")[0]
        others = ", ".join(
            f"{_said(said, language)} {count}"
            for said, count in counts.most_common()
            if said != right
        )
        first, three = share(r.first for r in mine), share(r.among_three for r in mine)
        lines.append(f"| {_words(name, language)} | {first:.0f} % | {three:.0f} % | {others} |")
    return "\n".join(lines)


def _reliability(rows: Sequence[Outcome], language: Language) -> str:
    lines = [_texts()["reliability_head"].to(language)]
    for low, high, count, right in reliability(rows):
        bar = "█" * round(right / 5)
        lines.append(f"| {100 * low:.0f} … {100 * high:.0f} % | {count} | {right:.0f} % | {bar} |")
    return "\n".join(lines)


def _amounts(measured: Measured, language: Language) -> str:
    curves = found(measured)
    amounts = [f"{amount:g}" for amount, _ in curves[next(iter(BY_NAME))]]
    head = _texts()["amounts_head"].to(language)
    lines = [head.format(amounts=" | ".join(amounts), rules="---|" * len(amounts))]
    for name, side in BY_NAME.items():
        curve = curves[name]
        bars = "".join(_BARS[min(7, int(of / 12.5))] for _, of in curve)
        shares = " | ".join(f"{of:.0f}" for _, of in curve)
        least = smallest(curve)
        begins = "—" if least is None else f"{side.at(least):.3g}"
        words = _words(name, language)
        lines.append(f"| {words} | {bars} | {shares} | {begins} | {side.noticeable:g} |")
    return "\n".join(lines)


def _not_driven(measured: Measured, language: Language) -> str:
    text = _texts()["not_driven"].to(language)
    head = text.format(
        cars=len(measured.idle),
        idle=_counted(measured.idle, language),
        first=f"{share(row.first for row in measured.idle):.0f}",
        wrong=f"{share(map(is_wrong, measured.idle)):.0f}",
    )
    lines = [head]
    for name in BY_NAME:
        cells = []
        for rows in (measured.idle, measured.after):
            mine = [row for row in rows if name in row.car.defects]
            others = Counter(
                _said(row.named[0] if row.named else row.ranking.verdict.value, language)
                for row in mine
                if not row.first
            )
            cells.append(f"{share(row.first for row in mine):.0f} %")
            cells.append(", ".join(f"{said} {count}" for said, count in others.most_common()))
        lines.append(f"| {_words(name, language)} | {' | '.join(cells)} |")
    return "\n".join(lines)


def _counted(rows: Sequence[Outcome], language: Language) -> str:
    counts = Counter(row.ranking.verdict.value for row in rows)
    return ", ".join(f"{_said(each, language)} {count}" for each, count in counts.items())


def _several(measured: Measured, language: Language) -> str:
    text = _texts()["several"].to(language)
    return text.format(
        cars=len(measured.sound),
        sound=_counted(measured.sound, language),
        pairs=len(measured.pairs),
        both=f"{share(row.among_three for row in measured.pairs):.0f}",
        one=f"{share(row.first for row in measured.pairs):.0f}",
        unknown_cars=len(measured.unknown),
        unknown=_counted(measured.unknown, language),
        certain_other=sum(row.certain for row in measured.unknown),
    )
