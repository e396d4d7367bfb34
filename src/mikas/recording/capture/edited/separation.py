"""Separate the recordings that another tool has merged: each gets a section of its own.

`mergecap` puts the ports of several files into one section, with their packets in order of time or
one after the other, and the notes between them. In the separated capture every section is one port,
so what follows the reader never meets two cars at once. A file of this program, or such files
joined end to end, is one already, which a plain search (`marks`) shows.

A note has no port and no time that other tools know, so they leave it where it was: behind a packet
of its own file. `_Section` places it by that. Notes that can't be placed are left out, and a note
of the kind `LEFT_OUT` in the separated capture says so.
"""

from __future__ import annotations

import struct
from contextlib import ExitStack, suppress
from dataclasses import replace
from functools import partial
from tempfile import SpooledTemporaryFile
from typing import BinaryIO, Final, cast

from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.edited.marks import Marked
from mikas.recording.capture.edited.unit_changes import (
    NEAR,
    Group,
    PlacedNote,
    UnitChange,
    are_of_one_unit,
    groups_of,
    is_head,
    parts_of,
)
from mikas.recording.capture.notes import Kind, Note, read_block, said_in_place
from mikas.recording.capture.scan import RawBlock, Unreadable, read_whole, scan
from mikas.recording.capture.temporary import temporary_capture

_WINDOW: Final = 1 << 16
_SPOOLED: Final = 1 << 16  # bytes of a port that stay in memory
_MOST_PORTS: Final = 256
_MOST_NOTES: Final = 1000  # that wait for the packet behind them
_DAMAGE: Final = b"\xff" * 12
_UNDESCRIBED: Final = 0xFFFF_FFFF  # a number that no interface has


class MergeSearch:
    """Finds out, from what `marked` yields of a capture, whether it is a merged one."""

    def __init__(self) -> None:
        self.found: bool = False
        """A section so far has several ports, or units that are not one."""
        self._ports, self._units = _Ports(), UnitChange()

    def add(self, item: Marked) -> None:
        """Take the next of them."""
        match item:
            case pcapng.Section():
                self._ports, self._units = _Ports(), UnitChange()
            case pcapng.Interface():
                self._ports.add(item)
            case Note():
                self._units.add(item)
        self.found |= self._ports.count > 1 or self._units.is_another


def separated(file: BinaryIO) -> BinaryIO:
    """Return a capture with the recordings of `file` one after the other.

    The result is a temporary file, which its close removes.
    """
    file.seek(0)
    return temporary_capture(partial(_separate, file))


class _Ports:
    """The ports of a section: an interface that differs from the one before by an earlier zero
    alone is the same port (`CaptureWriter` needs it for times below zero).
    """

    def __init__(self) -> None:
        self.count = 0
        self._before: pcapng.Interface | None = None

    def add(self, interface: pcapng.Interface) -> bool:
        """Take the next interface; return whether it is a port not seen before."""
        if interface.link_type != pcapng.LINKTYPE_USER0:
            return False
        before, self._before, is_same = self._before, interface, False
        if before is not None and interface.tsoffset < before.tsoffset:
            is_same = replace(interface, tsoffset=before.tsoffset) == before
        self.count += not is_same
        return not is_same


class _Stream:
    """One port of a section. `first`: its notes before all packets; the blocks behind them are in
    the temporary `file`.
    """

    def __init__(self, section: RawBlock, file: BinaryIO) -> None:
        self.file = file
        self.order = section.order
        self._section = section
        self._described: list[RawBlock] = []
        self.interfaces: list[pcapng.Interface] = []
        self.first: Group = []
        self.begin: float | None = None  # the first packet's time
        self.last: float | None = None
        self.unit: Note | None = None  # the first one behind a packet
        self._whole = True  # no damage since the last block

    @property
    def is_empty(self) -> bool:
        """Whether it has nothing but interfaces."""
        return not self.first and not self.file.tell()

    def describe(self, raw: RawBlock, interface: pcapng.Interface) -> int:
        """Add an interface; return its number."""
        self._described.append(raw)
        self.interfaces.append(interface)
        return len(self.interfaces) - 1

    def write(self, block: RawBlock, body: bytes | None = None) -> None:
        """Append a block, perhaps with another body."""
        self.file.write(encoded(block, body))
        self._whole = True

    def damage(self, data: bytes) -> None:
        """Append bytes that are no block, once between two blocks."""
        if self._whole:
            self.file.write(data)
            self._whole = False

    def note(self, placed: PlacedNote) -> None:
        """Append a note."""
        self.write(placed.raw)
        if self.unit is None and placed.note.kind == Kind.UNIT:
            self.unit = placed.note

    def may_be_of(self, group: Group) -> bool:
        """Return whether these may be its first notes: those that it has do not say otherwise."""
        own = [] if self.unit is None else [self.unit]
        return are_of_one_unit([*(placed.note for placed in group), *own])

    @property
    def is_unknown(self) -> bool:
        """Whether no note says whose it is."""
        return self.unit is None and not self.first

    def set_apart(self, number: int) -> None:
        """Give the port a name of its own: as its notes are lost, it is no known car's."""
        for at, it in enumerate(self.interfaces):
            name = f"{it.name.partition('?')[0]}#{number}"
            raw = self._described[at]
            body = pcapng.encode(replace(it, name=name), self.order)[8:-4]
            self._described[at] = raw._replace(body=body)

    @property
    def head(self) -> bytes:
        """The section's and the port's description."""
        return encoded(self._section) + b"".join(map(encoded, self._described))

    def copy_to(self, out: BinaryIO) -> None:
        """Write the section, or one for each of the recordings that followed each other."""
        parts = parts_of(self.first, self.interfaces, self.order, self.file)
        if parts is None:
            out.write(self.head + said_in_place({"mixed": True}, self.order))
            return
        self.file.seek(0)
        for part in parts:
            out.write(self.head)
            out.writelines(encoded(placed.raw) for placed in part.first)
            left = part.end - self.file.tell()
            while left and (data := self.file.read(min(left, _WINDOW))):
                out.write(data)
                left -= len(data)


def encoded(block: RawBlock, body: bytes | None = None) -> bytes:
    """Return the bytes of a block."""
    body = block.body if body is None else body
    total = struct.pack(block.order + "I", len(body) + 12)
    return struct.pack(block.order + "I", block.kind) + total + body + total


def _separate(file: BinaryIO, out: BinaryIO) -> None:
    section: _Section | None = None
    with ExitStack() as open_files:
        for item in scan(file):
            if isinstance(item, RawBlock) and item.kind == pcapng.SECTION:
                if section is not None:
                    section.finish(out)
                    open_files.close()
                section = _Section(item, open_files)
            elif section is not None:
                section.add(item, _raw(file, item))
            elif isinstance(item, RawBlock):  # the file has lost its begin
                out.write(encoded(item))
            else:
                out.write(_DAMAGE)
        if section is not None:
            section.finish(out)


def _raw(file: BinaryIO, item: RawBlock | Unreadable) -> bytes:
    """Return the bytes that are no block; the end of a cut block at most."""
    if isinstance(item, RawBlock):
        return b""
    if not item.cut:
        return _DAMAGE
    file.seek(item.offset)
    return read_whole(file, min(item.end - item.offset, _WINDOW))


class _Section:
    """One section, as it is read: its ports, and the notes since the last packet."""

    def __init__(self, start: RawBlock, open_files: ExitStack) -> None:
        self._start, self._open = start, open_files
        self._streams: list[_Stream] = []
        self._described: _Stream | None = None  # the port of the last interface
        self._numbers: list[tuple[_Stream, pcapng.Interface, int] | None] = []
        self._ports = _Ports()
        self._waiting: Group = []
        self._first: Group = []  # before all packets
        self._last: _Stream | None = None  # of the last packet
        self._left_out = 0
        self._cut = b""

    def add(self, item: RawBlock | Unreadable, data: bytes) -> None:
        """Take the next block, or the `data` that are none."""
        if isinstance(item, Unreadable):
            if item.cut:
                self._cut = data
                return
            begun = [stream for stream in self._streams if stream.begin is not None]
            for stream in begun or [self._stream()]:
                stream.damage(data)
            return
        block: pcapng.Block | None = None
        with suppress(pcapng.Malformed):
            block = pcapng.parse(item.kind, item.body, item.order)
            if block is None:
                return
        match block:
            case pcapng.Interface():
                self._describe(item, block)
            case pcapng.EnhancedPacket():
                self._packet(item, block)
            case pcapng.Custom():
                if note := read_block(block):
                    self._note(item, note)
            case pcapng.SimplePacket():
                place = self._numbers[0] if self._numbers else None
                (place[0] if place else self._stream()).write(item)
            case _:  # an unreadable body: its message stays
                if item.kind == pcapng.INTERFACE:  # later interfaces keep their numbers
                    self._numbers.append(None)
                self._stream().write(item)

    def _stream(self) -> _Stream:
        """Return the first port, for all that belongs to none."""
        return self._streams[0] if self._streams else self._begin()

    def _begin(self) -> _Stream:
        file = SpooledTemporaryFile(max_size=_SPOOLED)  # noqa: SIM115  (the stack closes it)
        self._open.enter_context(file)
        stream = _Stream(self._start, cast("BinaryIO", file))
        self._streams.append(stream)
        return stream

    def _describe(self, raw: RawBlock, interface: pcapng.Interface) -> None:
        is_new = self._ports.add(interface)
        if self._ports.count > _MOST_PORTS:
            self._numbers.append(None)
            return
        stream = self._described
        if interface.link_type == pcapng.LINKTYPE_USER1:  # it stands behind that of its unit
            stream = stream or self._stream()
        elif interface.link_type != pcapng.LINKTYPE_USER0:
            stream = self._stream()
        elif is_new:
            stream = self._described = self._stream() if stream is None else self._begin()
        assert stream is not None  # the section's first interface is a new port
        self._numbers.append((stream, interface, stream.describe(raw, interface)))

    def _packet(self, raw: RawBlock, packet: pcapng.EnhancedPacket) -> None:
        known = packet.interface < len(self._numbers)
        place = self._numbers[packet.interface] if known else None
        if place is None:
            undescribed = struct.pack(raw.order + "I", _UNDESCRIBED)
            self._stream().write(raw, undescribed + raw.body[4:])
            return
        stream, interface, number = place
        if interface.link_type == pcapng.LINKTYPE_USER1:
            self._instrument(stream, raw, interface.time(packet.ticks), number)
            return
        if interface.link_type != pcapng.LINKTYPE_USER0:
            return
        time = interface.time(packet.ticks)
        self._place_notes(stream, time)
        stream.write(raw, struct.pack(raw.order + "I", number) + raw.body[4:])
        stream.begin = time if stream.begin is None else stream.begin
        stream.last, self._last = time, stream

    def _instrument(self, stream: _Stream, raw: RawBlock, time: float, number: int) -> None:
        """Write a packet of an instrument into the section of its unit."""
        if stream.begin is not None:
            self._place_notes(stream, time)
            self._last = stream
        stream.write(raw, struct.pack(raw.order + "I", number) + raw.body[4:])

    def _note(self, raw: RawBlock, note: Note) -> None:
        if len(self._waiting) < _MOST_NOTES:
            self._waiting.append(PlacedNote(raw, note))
        else:
            self._left_out += 1

    def _place_notes(self, following: _Stream | None, time: float = 0.0) -> None:
        """Write the notes since the last packet; a packet of `following` at `time` is next."""
        waiting, self._waiting = self._waiting, []
        if self._last is None:
            self._first = waiting
            return
        own = len(waiting)
        if waiting and following is not None and following.begin is None:
            own = self._begin_of_next(waiting, self._last, time)
            following.first = waiting[own:]
        for placed in waiting[:own]:
            self._last.note(placed)

    def _place_first(self) -> None:
        """Place the notes before all packets: those of each file begin with its unit."""
        ports = [stream for stream in self._streams if stream.interfaces]
        groups = groups_of(self._first)
        if len(ports) < 2:
            self._stream().first = self._first
            return
        if not all(map(is_head, groups)):
            groups = []
        ports = [port for port in ports if not port.first]
        places: list[_Stream | None] = [*ports]
        if len(places) != len(groups):
            places = [_near(ports, each) for each in groups]
        self._left_out += len(self._first)
        for port, group in zip(places, groups, strict=True):
            is_one = port is not None and places.count(port) == 1
            if port and is_one and port.begin is not None and _since(group, port.begin) >= 0.0:
                port.first = group
                self._left_out -= len(group)

    def _begin_of_next(self, waiting: Group, last: _Stream, time: float) -> int:
        """Return how many notes are of the `last` port, where another begins with a packet at
        `time`: perhaps the first notes of that one are the last of these.
        """
        units = [at for at, placed in enumerate(waiting) if placed.note.kind == Kind.UNIT]
        if not units or not is_head(waiting[units[-1] :]):
            return len(waiting)
        noted = waiting[units[-1]].note.time
        since = abs(noted - (last.last or 0.0))
        has_unit = last.unit is not None or any(it.note.kind == Kind.UNIT for it in self._first)
        if not has_unit and len(units) == 1 and since < NEAR:
            return len(waiting)
        return units[-1] if abs(time - noted) <= since or has_unit else len(waiting)

    def finish(self, out: BinaryIO) -> None:
        """Write the ports, one after the other."""
        self._place_notes(None)
        self._place_first()
        for number, stream in enumerate(self._streams if self._left_out else (), 1):
            if stream.is_unknown:
                stream.set_apart(number)
        used = [each for each in self._streams if not each.is_empty]
        for stream in used or [self._stream()]:
            stream.copy_to(out)
        if self._left_out:
            out.write(said_in_place({"count": self._left_out}, self._start.order))
        out.write(self._cut)


def _since(group: Group, time: float) -> float:
    """Return the seconds from these notes to a packet; a tenth more, for the clocks' steps."""
    return time - group[0].note.time + 0.1


def _near(ports: list[_Stream], group: Group) -> _Stream | None:
    """Return the only port that begins soon after these notes, and has no other unit's."""
    begun = [it for it in ports if it.begin is not None and 0.0 <= _since(group, it.begin) <= NEAR]
    if len(begun) > 1:
        begun = [it for it in begun if it.may_be_of(group)]
    return begun[0] if len(begun) == 1 else None
