"""What a rule waits for: channels of its formulas that nothing gives now.

An instrument beside the unit comes and goes while a program runs. A rule that names a channel of
one that is away has no value until that one is there.
"""

from __future__ import annotations

from collections.abc import Iterable

from mikas.catalog import Catalog, InstrumentChannel
from mikas.i18n import Text
from mikas.options import nearest


def awaited(names: Iterable[str], catalog: Catalog) -> tuple[str, ...]:
    """Return the channels that `names` are or need, and that nothing gives now."""
    names = tuple(dict.fromkeys(names))
    unknown = [name for name in names if name not in catalog.formula_channels]
    needed = catalog.required_beside(names)
    return (*unknown, *(name for name in needed if name not in catalog.beside))


def waiting_for(names: Iterable[str], catalog: Catalog) -> Text | None:
    """Return why a rule with these channels can't act now, and what to do; None: it can."""
    texts = [_text(name, catalog) for name in awaited(names, catalog)]
    if not texts:
        return None
    return Text(" ".join(text.en for text in texts), " ".join(text.ru for text in texts))


def _text(name: str, catalog: Catalog) -> Text:
    if isinstance(catalog.described(name), InstrumentChannel):
        return Text(
            f"No instrument beside the unit gives {name}: add one that does on Connection.",
            f"Рядом с блоком нет прибора, который даёт {name}: добавьте его на экране «Связь».",
        )
    close = nearest(name, catalog.formula_channels)
    return Text(
        f"Neither the unit nor an instrument beside it gives {name}: correct the name"
        + (f" (the nearest is {close[0]})" if close else "")
        + ", or add the instrument on Connection.",
        f"{name} не даёт ни блок, ни прибор рядом с ним: исправьте имя"
        + (f" (ближайшее — {close[0]})" if close else "")
        + " или добавьте прибор на экране «Связь».",
    )
