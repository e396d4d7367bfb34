"""The generated places of pages that people edit: from one comment to the next."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping

_PLACE = re.compile(
    r"(<!-- made by python -m tools\.docs\.generated: (\w+) -->\n).*?(<!-- end -->)", re.DOTALL
)


def filled(text: str, made: Mapping[str, Callable[[], str]]) -> str:
    """Return the page with each place filled by the function of its name."""
    return _PLACE.sub(lambda place: f"{place[1]}\n{made[place[2]]()}\n{place[3]}", text)
