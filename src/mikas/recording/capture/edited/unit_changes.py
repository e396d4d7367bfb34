"""Find where, in the packets of one port, another recording's packets begin.

`mergecap` joins ports that are described alike, as those of two cars on one adapter. Their units
show it: a recording has one, or says that another follows. Recordings that lie one after the other
are cut at the largest step of time between the notes of both units, or where the first packet after
a recording's first notes has their time. Without such a step their packets may lie between each
other, and no packet is of a known car.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import BinaryIO, Final

from mikas.commands.unit import version_of
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.notes import Kind, Note, read_block
from mikas.recording.capture.scan import RawBlock, scan

NEAR: Final = 1.0  # s between a recording's first notes and its first packet
_STEP: Final = 1.0  # s
_BACK: Final = 10.0  # times as much a step back counts: a merge in order of time has none
_HEAD_KINDS: Final = frozenset(
    [Kind.UNIT, Kind.CATALOG, Kind.CAR, Kind.PLAN, Kind.STATE, Kind.FAULTS]
)


@dataclass(frozen=True, slots=True)
class PlacedNote:
    """A note of a merged file, and its block."""

    raw: RawBlock
    note: Note


Group = list[PlacedNote]


def groups_of(notes: Iterable[PlacedNote]) -> list[Group]:
    """Return the notes before all packets, those of each unit in a group."""
    groups: list[Group] = []
    for placed in notes:
        if placed.note.kind == Kind.UNIT or not groups:
            groups.append([])
        groups[-1].append(placed)
    return groups


def is_head(group: Group) -> bool:
    """Return whether these may be the first notes of one recording: made at once, each once."""
    kinds = [each.note.kind for each in group]
    alike = len({each.note.time for each in group if each.note.kind != Kind.FAULTS}) == 1
    return alike and len(set(kinds)) == len(kinds) and _HEAD_KINDS.issuperset(kinds)


class UnitChange:
    """The units of one port, one after the other. `is_another`: the latest is not the one before,
    though its note does not say so.
    """

    def __init__(self) -> None:
        self.is_another: bool = False
        self._known: tuple[object, ...] = ()

    def add(self, note: Note) -> None:
        """Take the next note."""
        if note.kind != Kind.UNIT:
            return
        pieces = note.data.get("passports")
        found = (
            version_of(note.data.get("version_code")),
            *(pieces[:8] if isinstance(pieces, Sequence) and not isinstance(pieces, str) else ()),
        )
        said = note.data.get("another") is True
        self.is_another = not said and any(
            own != others
            for own, others in zip(self._known, found, strict=False)
            if own is not None and others is not None
        )
        self._known = found


def are_of_one_unit(notes: Iterable[Note]) -> bool:
    """Return whether none of these notes is of another unit than the one before."""
    units = UnitChange()
    for note in notes:
        units.add(note)
        if units.is_another:
            return False
    return True


@dataclass(frozen=True, slots=True)
class UnitPart:
    """One recording: its `first` notes, and where its other blocks end in the file."""

    first: Group
    end: int


def parts_of(
    first: Group, interfaces: Sequence[pcapng.Interface], order: pcapng.Order, file: BinaryIO
) -> list[UnitPart] | None:
    """Return the recordings of one port; None: which packet is of which is not known.

    `first`: the notes before all packets; `file`: the blocks from the first packet on.
    """
    units, groups = UnitChange(), groups_of(first)
    several = False
    for placed in first:
        units.add(placed.note)
        several |= units.is_another
    search = _ByHeads(groups) if several else _ByUnits(first, units)
    for item in scan(file, 0, order):
        if not isinstance(item, RawBlock):
            continue
        block: pcapng.Block | None = None
        with suppress(pcapng.Malformed):
            block = pcapng.parse(item.kind, item.body, item.order)
        if isinstance(block, pcapng.EnhancedPacket) and block.interface < len(interfaces):
            search.add_packet(interfaces[block.interface].time(block.ticks), item.offset)
        elif isinstance(block, pcapng.Custom) and (note := read_block(block)):
            search.add_note(note, item.offset)
    return search.result(file.seek(0, 2))


class _Steps:
    """The steps of time from packet to packet; one back counts more."""

    def __init__(self) -> None:
        self._before: float | None = None

    def to(self, time: float) -> float:
        step = 0.0 if self._before is None else time - self._before
        self._before = time
        return step if step >= 0.0 else -_BACK * step


def _is_soon(time: float, noted: float) -> bool:
    """Return whether a packet is the first one behind a recording's first notes."""
    return 0.0 <= time - noted + 0.1 <= NEAR


class _ByUnits:
    """Cuts between the notes of units that lie between the packets."""

    def __init__(self, first: Group, units: UnitChange) -> None:
        self._first, self._units = first, units
        self._steps = _Steps()
        self._places: list[int] = []
        self._is_known = True
        self._step, self._place = 0.0, 0  # the largest since the last unit's note
        self._unit: int | None = None  # another one's note, since the last packet
        self._noted: float | None = None  # the time of the same one's

    def add_packet(self, time: float, offset: int) -> None:
        step = self._steps.to(time)
        noted, self._noted = self._noted, None
        if self._unit is not None:
            self._decide(self._unit, step)
        elif step > self._step and not (noted is not None and _is_soon(time, noted)):
            self._step, self._place = step, offset

    def add_note(self, note: Note, offset: int) -> None:
        if note.kind != Kind.UNIT:
            return
        self._units.add(note)
        if not self._units.is_another:
            self._step, self._noted = 0.0, note.time
        elif self._unit is None:
            self._unit = offset
        else:  # three units without a packet between
            self._is_known = False

    def _decide(self, unit: int, step: float) -> None:
        """Begin the unit's recording at its note, if a `step` follows, or at the largest before."""
        if step >= max(_STEP, self._step):
            self._places.append(unit)
        elif self._step >= _STEP:
            self._places.append(self._place)
        else:
            self._is_known = False
        self._step, self._unit = 0.0, None

    def result(self, end: int) -> list[UnitPart] | None:
        if self._unit is not None:
            self._decide(self._unit, _STEP)
        ends = [*self._places, end]
        firsts = [self._first, *([] for _ in self._places)]
        parts = [UnitPart(*each) for each in zip(firsts, ends, strict=True)]
        return parts if self._is_known else None


class _ByHeads:
    """Cuts at the packets that follow the first notes of each recording, which all lie in front:
    so `mergecap` puts them, in the order of the files.
    """

    def __init__(self, groups: list[Group]) -> None:
        self._groups = sorted(groups, key=lambda group: group[0].note.time)
        self._is_known = all(map(is_head, groups))
        self._steps = _Steps()
        self._places: list[int] = []

    def add_packet(self, time: float, offset: int) -> None:
        step = self._steps.to(time)
        begun = len(self._places)
        if begun == len(self._groups):
            return
        near = _is_soon(time, self._groups[begun][0].note.time)
        if near and (not begun or step >= _STEP):
            self._places.append(offset)
        elif not begun:
            self._is_known = False

    def add_note(self, note: Note, offset: int) -> None:  # noqa: ARG002  (as of `_ByUnits`)
        """Take a later note: of a unit that is not the present recording's, all may be mixed."""
        if note.kind == Kind.UNIT and self._places:
            present = self._groups[len(self._places) - 1]
            self._is_known &= are_of_one_unit([*(placed.note for placed in present), note])

    def result(self, end: int) -> list[UnitPart] | None:
        if not self._is_known or len(self._places) < len(self._groups):
            return None
        ends = [*self._places[1:], end]
        return [UnitPart(*each) for each in zip(self._groups, ends, strict=True)]
