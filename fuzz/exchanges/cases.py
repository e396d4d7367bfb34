"""Case N of seed S: one or two sessions, changed; as one section, two ports or two sections."""

from __future__ import annotations

from collections.abc import Callable, Set
from dataclasses import dataclass, replace
from random import Random

from fuzz.exchanges.lines import file_of, text_of
from fuzz.exchanges.mutations import Line, mutated
from fuzz.exchanges.sessions import Packet, Truth, drawn

Place = tuple[int, int]
"""A section and a port."""
Sections = tuple[tuple[Packet, ...], ...]


@dataclass(frozen=True, slots=True)
class Case:
    """`sections`: the changed lines; `recorded`: before. `truths`: what the unit of each place
    gave. `changes`: the names of the mutations.
    """

    number: int
    sections: Sections
    recorded: Sections
    truths: dict[Place, Truth]
    changes: tuple[str, ...]

    @property
    def data(self) -> bytes:
        """The file."""
        return file_of(self.sections)

    @property
    def unchanged(self) -> Case:
        """The case without the changes."""
        return replace(self, sections=self.recorded)

    def text(self) -> str:
        """Return the case for a person."""
        return f"{', '.join(self.changes)}\n{text_of(self.sections)}"

    def without(self, section: int, packets: Set[Packet]) -> Case:
        """Return the case without some packets of a section; they were not recorded either."""
        origins = {(it.port, it.origin) for it in packets}
        return replace(
            self,
            sections=_part(self.sections, section, lambda it: it not in packets),
            recorded=_part(self.recorded, section, lambda it: (it.port, it.origin) not in origins),
        )


def _part(sections: Sections, section: int, kept: Callable[[Packet], bool]) -> Sections:
    less = tuple(filter(kept, sections[section]))
    return (*sections[:section], less, *sections[section + 1 :])


def case(seed: int, number: int) -> Case:
    """Return one case; the same everywhere. Every 16th is not changed."""
    random = Random(f"exchanges {seed}:{number}")
    made = [drawn(random) for _ in range(random.choice((1, 1, 1, 1, 2, 2)))]
    before = [list(it.packets) for it in made]
    after, changes = before, []
    if number % 16:
        after = []
        for line in before:
            changed, names = mutated(random, line)
            after.append(changed)
            changes += names
    if len(made) == 2 and random.random() < 0.5:  # two ports
        places = {(0, at): it.truth for at, it in enumerate(made)}
        lines = _interleaved(*after), _interleaved(*before)
        return Case(number, lines[:1], lines[1:], places, tuple(changes))
    places = {(at, 0): it.truth for at, it in enumerate(made)}
    sections, recorded = tuple(map(tuple, after)), tuple(map(tuple, before))
    return Case(number, sections, recorded, places, tuple(changes))


def _interleaved(one: Line, other: Line) -> tuple[Packet, ...]:
    """Return two lines that were recorded at once, each in its own order."""
    both: list[Packet] = []
    one = list(one)
    other = [it._replace(port=1) for it in other]
    while one and other:
        line = one if one[0].time <= other[0].time else other
        both.append(line.pop(0))
    return (*both, *one, *other)
