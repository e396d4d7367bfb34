"""Reading a capture: packets in the order of the file, and problems where it is damaged.

A capture is a pcapng file with interfaces of link type 147 whose packets have a direction. Those of
instruments (148) have readers of their own (`capture.instruments`); other interfaces, unknown
blocks and other programs' notes are skipped.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from mikas.cleaning import clean_line, public_port
from mikas.i18n import Text
from mikas.link.base import BITS_PER_BYTE, Direction
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.clock import RecordingClock
from mikas.recording.capture.dating import corrections_in, dated_index, moved
from mikas.recording.capture.notes import INSTRUMENT_PORT, LEFT_OUT, Note, read_block
from mikas.recording.capture.opening import opened, opened_capture
from mikas.recording.capture.scan import (
    RawBlock,
    Unreadable,
    scan,
)

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

FLAGS: Final = {Direction.SENT: pcapng.OUTBOUND, Direction.RECEIVED: pcapng.INBOUND}
_DIRECTIONS: Final = {flags: direction for direction, flags in FLAGS.items()}
_HERE: Final = "mikas"  # begin of this program's name in a section
_OURS: Final = (pcapng.LINKTYPE_USER0, pcapng.LINKTYPE_USER1, pcapng.LINKTYPE_USER2)
FASTEST: Final = 10_000_000  # baud; a higher rate is damage
_LATEST: Final = 1 << 52  # µs; in 2112: a later time is in another unit
_BAUDS: Final = range(50, 4_000_001)  # no adapter has other ones
_SHOWN: Final = 32  # bytes of a packet that is passed over
_MOST_INTERFACES: Final = 256  # of a recording; one has one, merged recordings have a few


@dataclass(frozen=True, slots=True)
class Source:
    """The origin of packets. `recording` counts the recordings in a file, from 0.

    Each is a session of its own: a file may be appended to.
    """

    recording: int
    url: str = ""
    description: str = ""
    baud: int = 0
    application: str = ""
    hardware: str = ""
    definition: str = ""
    """Of an instrument: the text of its definition."""
    foreign: bool = False
    """Whether these bytes are of another protocol, at another baud rate."""
    instrument: bool = False
    """Whether an instrument beside the unit sent these bytes."""

    @property
    def byte_time(self) -> float:
        """The seconds of a byte on the wire; at 9600 baud (§1) if the rate is not known."""
        return BITS_PER_BYTE / (self.baud if self.baud in _BAUDS else 9600)


@dataclass(frozen=True, slots=True)
class Packet:
    """One chunk of one direction. `time`: the link's clock; `offset`: of its block in the file."""

    direction: Direction
    data: bytes
    time: float
    offset: int
    comment: str = ""
    source: Source = Source(0)


@dataclass(frozen=True, slots=True)
class Problem:
    """An unreadable part of the file, from `offset`, and what it means.

    `stream`: the request of a stream whose responses follow, though it is missing itself.
    """

    offset: int
    text: Text
    stream: bytes | None = None


class CaptureReader:
    """The packets of a capture, in the order of the file, and the problems between them.

    Raises `CaptureError` if the file can't be opened, is empty, is no pcapng, or holds another kind
    of capture. Iterating raises only for an input error of the system: damaged or incomplete parts
    become a `Problem`. Each iteration reads from the start; memory does not grow with the file.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path: Path = Path(path)
        with opened_capture(path):
            pass

    def __iter__(self) -> Iterator[Packet | Problem]:
        with opened(self.path) as file:
            blocks = Blocks(corrections_in(file))
            for item in scan(file):
                for each in blocks.read(item):
                    if not isinstance(each, Note):
                        yield each

    def with_other_protocols(self, *, instruments: bool = False) -> Iterator[Packet | Problem]:
        """Iterate as over this; the K-Line's packets of other protocols come too, as `foreign`.

        `instruments`: and those of instruments beside the unit, as `instrument`.
        """
        others = _OURS if instruments else (pcapng.LINKTYPE_USER2,)
        with opened(self.path) as file:
            blocks = Blocks(corrections_in(file), others=others)
            for item in scan(file):
                for each in blocks.read(item):
                    if not isinstance(each, Note):
                        yield each

    def notes(self) -> Iterator[Note]:
        """Yield the notes of the file, in its order; damaged and foreign ones are left out.

        They are found without reading the packets, in a fraction of the time.
        """
        with opened(self.path) as file:
            yield from dated_index(file).notes


class Blocks:
    """Interprets the blocks of one file, one after the other.

    Blocks before the first section are those of a recording that has lost its beginning. If its
    first packet has the form that this program writes, its port is known except for the name.
    `clocks`: of the present ports, by number. `corrections`: seconds to add to the times of each
    recording (`capture.dating`). A shallow copy goes on from the same place. `link_type`: of the
    packets that are yielded: the unit's, or those of instruments; `others`: and of
    these link types.
    """

    def __init__(
        self,
        corrections: Mapping[int, float] | None = None,
        link_type: int = pcapng.LINKTYPE_USER0,
        *,
        others: tuple[int, ...] = (),
    ) -> None:
        self._link_types = {link_type, *others}
        self._recording = -1
        self._corrections = corrections or {}
        self._section: pcapng.Section | None = None
        self._interfaces: tuple[tuple[pcapng.Interface, Source], ...] = ()
        self.clocks: tuple[RecordingClock, ...] = ()

    @property
    def interfaces(self) -> tuple[tuple[pcapng.Interface, Source], ...]:
        """The present section's, by number; none in an unknown version."""
        return self._interfaces if self._section else ()

    @property
    def is_settled(self) -> bool:
        """Whether the clock of a port is settled: its next packets change nothing here."""
        return any(clock.is_settled for clock in self.clocks)

    @property
    def correction(self) -> float:
        """The seconds to add to the times of the present recording."""
        return self._corrections.get(max(0, self._recording), 0.0)

    def read(self, item: RawBlock | Unreadable) -> Iterator[Packet | Problem | Note]:
        """Yield the block's packet, note or problems."""
        if isinstance(item, Unreadable):
            text = _CUT if item.cut else _DAMAGED
            yield Problem(item.offset, text.filled(count=item.end - item.offset))
            return
        if self._recording < 0 and item.kind != pcapng.SECTION:
            self._recording = 0
            self._section = pcapng.Section(application=_HERE)
        if self._section is None and item.kind != pcapng.SECTION:
            return  # the section's unknown version is reported at its begin
        try:
            block = pcapng.parse(item.kind, item.body, item.order)
        except pcapng.Malformed:
            yield Problem(item.offset, _DAMAGED.filled(count=item.end - item.offset))
            if item.kind == pcapng.INTERFACE:  # later interfaces keep their numbers
                yield from self._add(pcapng.Interface(link_type=-1), item.offset)
            return
        yield from self._content(block, item.offset)

    def _content(
        self, block: pcapng.Block | None, offset: int
    ) -> Iterator[Packet | Problem | Note]:
        match block:
            case pcapng.Section(version=(major, _)):
                self._recording += 1
                self._interfaces, self.clocks = (), ()
                self._section = block if major == 1 else None
                if self._section is None:
                    yield Problem(offset, _VERSION.filled(version=major))
            case pcapng.Interface():
                yield from self._add(block, offset)
                if block.link_type == pcapng.LINKTYPE_USER1:
                    yield Note(
                        INSTRUMENT_PORT, 0.0, recording=max(0, self._recording), offset=offset
                    )
                if block.link_type not in _OURS:
                    yield Problem(offset, _OTHER_INTERFACE.filled(type=block.link_type))
            case pcapng.EnhancedPacket():
                yield from self._packet(block, offset)
            case pcapng.Custom():
                note = read_block(block)
                if note is not None and note.kind == LEFT_OUT:
                    yield _made_ready(note, offset)
                elif note is not None:
                    note = moved(note, self.correction)
                    yield replace(note, recording=self._recording, offset=offset)
            case pcapng.SimplePacket():  # always of the first interface
                if not self._interfaces or self._is_ours(0):
                    yield Problem(offset, _NO_DIRECTION)

    def _add(self, interface: pcapng.Interface, offset: int) -> Iterator[Problem]:
        if len(self._interfaces) == _MOST_INTERFACES:
            yield Problem(offset, _TOO_MANY_INTERFACES)
            return
        section = self._section or pcapng.Section()
        source = Source(
            recording=self._recording,
            url=public_port(clean_line(interface.name)),
            description=clean_line(interface.description),
            baud=interface.speed if interface.speed <= FASTEST else 0,
            application=clean_line(section.application),
            hardware=clean_line(section.hardware),
            definition=interface.comment if interface.link_type == _OURS[1] else "",
            foreign=interface.link_type == pcapng.LINKTYPE_USER2,
            instrument=interface.link_type == pcapng.LINKTYPE_USER1,
        )
        self._interfaces += ((interface, source),)
        self.clocks += (RecordingClock(),)

    def _is_ours(self, number: int) -> bool:
        return self._interfaces[number][0].link_type in self._link_types

    def _is_as_written_here(self, block: pcapng.EnhancedPacket) -> bool:
        """Return whether a packet without an interface has the form that `CaptureWriter` writes."""
        here = self._section is not None and self._section.application.startswith(_HERE)
        whole = block.interface == 0 and not block.comment and not block.cut
        return here and whole and block.flags in FLAGS.values() and block.ticks < _LATEST

    def _packet(self, block: pcapng.EnhancedPacket, offset: int) -> Iterator[Packet | Problem]:
        if not self._interfaces and self._is_as_written_here(block):
            yield from self._add(pcapng.Interface(), offset)
            yield Problem(offset, _HEADLESS)
        number = block.interface
        if number >= len(self._interfaces):
            yield Problem(offset, _NO_INTERFACE)
            return
        if not self._is_ours(number):
            return
        interface, source = self._interfaces[number]
        direction = _DIRECTIONS.get(block.flags & 3)
        if direction is None:
            yield Problem(offset, _NO_DIRECTION)
            return
        time = interface.time(block.ticks) + self.correction
        clock, is_possible = self.clocks[number].after_packet(time)
        if clock is not self.clocks[number]:
            self.clocks = (*self.clocks[:number], clock, *self.clocks[number + 1 :])
        if not is_possible:
            yield Problem(offset, _TIME.filled(data=_shown(block.data)))
            return
        if block.cut:
            yield Problem(offset, _PACKET_CUT.filled(count=block.cut))
        yield Packet(direction, block.data, time, offset, block.comment, source)


def _shown(data: bytes) -> str:
    """Return a packet's bytes in hex, at most a line of them."""
    digits = data[:_SHOWN].hex(" ").upper() or "—"
    return f"{digits} …" if len(data) > _SHOWN else digits


def _made_ready(note: Note, offset: int) -> Problem:
    """Return what `opening` did to a file that another program has changed."""
    seconds, count, stream = (note.data.get(key) for key in ("seconds", "count", "stream"))
    if note.data.get("mixed") is True:
        return Problem(offset, _MIXED)
    if isinstance(stream, list):
        request = bytes(it for it in stream if isinstance(it, int) and 0 <= it < 256)
        return Problem(offset, _PLANNED_STREAM if stream else _CUT_STREAM, request or None)
    if isinstance(seconds, float):
        shown = f"{seconds:+.6f}".rstrip("0").rstrip(".")
        return Problem(offset, _SHIFTED.filled(seconds=shown))
    text = _UNPLACED if note.data.get("shifted") is True else _NOTES_LEFT_OUT
    return Problem(offset, text.filled(count=count if isinstance(count, int) else "?"))


_OTHER_INTERFACE = Text(
    "packets of another kind of interface (link type {type}, not 147) are passed over",
    "пакеты интерфейса другого рода (тип канала {type}, а не 147) пропущены",
)
_CUT = Text(
    "the recording was interrupted here: its last bytes ({count}) are an unfinished packet; "
    "everything before it is whole",
    "запись здесь прервана: последние байты ({count}) — незаконченный пакет; всё до него цело",
)
_DAMAGED = Text(
    "damaged bytes of the file ({count}) are passed over",
    "повреждённые байты файла ({count}) пропущены",
)
_HEADLESS = Text(
    "the beginning of this recording, which describes its port, is damaged or missing; its packets "
    "are read as this program writes them",
    "начало этой записи, где описан порт, повреждено или пропало; пакеты читаются так, как их "
    "пишет эта программа",
)
_TOO_MANY_INTERFACES = Text(
    "this recording describes more than 256 ports; this one is passed over",
    "в этой записи описано больше 256 портов; этот пропущен",
)
_MIXED = Text(
    "recordings of several units lie mixed in one port, so it is unknown whose a value is: nothing "
    "of them is read; `mergecap -I none` keeps them apart",
    "записи нескольких блоков перемешаны в одном порту, и чьё значение — неизвестно: отсюда не "
    "читается ничего; `mergecap -I none` оставляет их раздельными",
)
_NOTES_LEFT_OUT = Text(
    "notes ({count}) are left out: another program moved them, so their port is unknown",
    "пометки ({count}) пропущены: другая программа переместила их, и их порт неизвестен",
)
_SHIFTED = Text(
    "another program has shifted packets against their notes by {seconds} s; the notes follow them",
    "другая программа сдвинула пакеты относительно пометок на {seconds} с; пометки следуют за ними",
)
_UNPLACED = Text(
    "notes ({count}) are left out: another program has shifted packets, so their times are unknown",
    "пометки ({count}) пропущены: другая программа сдвинула пакеты, и время пометок неизвестно",
)
_PLANNED_STREAM = Text(
    "a stream goes on here whose request is missing; its values are read by the noted plan",
    "здесь продолжается поток, запроса которого нет; значения прочитаны по отмеченному плану",
)
_CUT_STREAM = Text(
    "a stream goes on here whose request is missing, and no plan says what is in it: it has no "
    "values",
    "здесь продолжается поток, запроса которого нет, и по плану не узнать, что в нём: значений нет",
)
_VERSION = Text(
    "a part of the file has pcapng version {version}, which is not known here; it is passed over",
    "часть файла в неизвестной версии pcapng ({version}); она пропущена",
)
_NO_INTERFACE = Text(
    "a packet whose port is not described is passed over",
    "пропущен пакет, порт которого не описан",
)
_NO_DIRECTION = Text(
    "a packet that does not say whether it was sent or received is passed over",
    "пропущен пакет, в котором не указано, послан он или принят",
)
_TIME = Text(
    "a packet is passed over: no recording can have its time; its bytes: {data}",
    "пропущен пакет с временем, какого в записи быть не может; его байты: {data}",
)
_PACKET_CUT = Text(
    "the next packet was recorded without its last bytes ({count})",
    "следующий пакет записан без последних байтов ({count})",
)
