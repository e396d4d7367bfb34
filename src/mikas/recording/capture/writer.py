"""Writing a capture: all bytes on the wire, in a pcapng file.

`CaptureWriter` is the sink of `mikas.link.base`: one packet a chunk of one direction, with the
link's time in microseconds (`capture.coalescer` joins chunks before). Notes on the session are
custom blocks in between. `docs/reference/capture.md` has the format field by field.

Every packet goes to the operating system at once, unbuffered: the line brings 960 bytes a second
(§1) and a write takes microseconds. So a `kill -9` loses nothing, and no timer has to flush.
"""

from __future__ import annotations

import errno
import os
import threading
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO, Final, Self

from mikas.cleaning import public_port
from mikas.errors import (
    CaptureError,
    MikasError,
    UnfitFile,
    system_error,
)
from mikas.files import open_regular
from mikas.files.locks import hold
from mikas.i18n import Text
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.dating import corrections, moved
from mikas.recording.capture.edited.note_times import shift_at_end
from mikas.recording.capture.notes import Note, block_of, index
from mikas.recording.capture.opening import FULL, capture_error, is_packed
from mikas.recording.capture.reader import FLAGS, CaptureReader
from mikas.saving import write_all

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mikas.link.base import Direction

_LARGEST_CHUNK: Final = 1 << 16  # tools refuse packets over 256 KiB; a longer chunk is split
_MICROSECOND = 1_000_000


@dataclass(slots=True)
class _Described:
    """A port as the file describes it; `number`: of its latest description."""

    interface: pcapng.Interface
    number: int = 0


class CaptureWriter:
    """Appends the bytes on the wire to `path`. Implements `mikas.link.base.Sink`.

    While the file is written, no other mikas changes or deletes it (`mikas.files.locks`).
    An existing file is refused, unless `overwrite` discards it. An existing named pipe is written
    to: other programs can read along. `pipe` false: only a new file is, as the user did not name
    it, and others may write to its folder.

    Every method that touches the file raises `CaptureError` if it can't be written: no room, no
    right, medium gone, file deleted meanwhile. The file stays valid: a half-written packet is
    removed. Any thread may add a note.

    `instruments`: the ports beside that of the unit (`capture.instruments`), for
    `record_instrument`.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        *,
        url: str,
        baud: int = 9600,
        overwrite: bool = False,
        pipe: bool = True,
        instruments: Sequence[pcapng.Interface] = (),
    ) -> None:
        self.path: Path = Path(path)
        self.deleted: bool = False
        """The file was deleted while it was recorded; its contents are lost."""
        unit = pcapng.Interface(name=public_port(url), speed=baud)
        self._ports = [_Described(each) for each in (unit, *instruments)]
        self._line = self._ports[0]  # of the bytes on the K-Line: another at another baud rate
        self._interfaces = 0
        self._end = 0  # of the last whole block
        self._checked = 0.0  # link's time of the last check that the file exists
        self._made = False
        self._broken = False  # a half-written block could not be removed
        self._lock = threading.RLock()
        try:
            self._file = self._open(overwrite=overwrite, pipe=pipe)
            self._links = os.fstat(self._file.fileno()).st_nlink
        except OSError as error:
            raise _not_begun(self.path, error) from error
        try:
            from importlib.metadata import version  # slow to import, and `watch` records nothing

            self._append(pcapng.Section(application=f"mikas {version('mikas')}"))
            for port in self._ports:
                self._describe_interface(port, tsoffset=0)
            self._begun_at = self._end  # the end of what every recording begins with
        except BaseException as error:
            self._file.close()
            if self._made:
                with suppress(OSError):  # else the same command would be refused
                    self.path.unlink()
            if isinstance(cause := error.__cause__, OSError):
                raise _not_begun(self.path, cause) from cause
            raise

    @property
    def size(self) -> int:
        """Bytes of the file so far, in whole blocks."""
        return self._end

    def record(self, direction: Direction, data: bytes, time: float) -> None:
        """Write one chunk; the operating system has it on return."""
        with self._lock:
            self._record(self._line, data, time, FLAGS[direction])

    def change_baud(self, baud: int | None) -> None:
        """Take the bytes on the K-Line as of another protocol; None: of the unit again.

        They get a port of their own in the file, of link type 149. Implements `BaudSink`.
        """
        with self._lock:
            unit = self._ports[0]
            self._line = unit
            if baud is not None:
                kind = pcapng.LINKTYPE_USER2
                self._line = _Described(replace(unit.interface, link_type=kind, speed=baud))
                self._check_writable()
                self._describe_interface(self._line, tsoffset=unit.interface.tsoffset)

    def record_instrument(self, number: int, data: bytes, time: float, comment: str = "") -> None:
        """Write a chunk that an instrument sent; of its begin or its end, a comment without data.

        `number`: of `instruments`.
        """
        with self._lock:
            self._record(self._ports[1 + number], data, time, pcapng.INBOUND, comment)

    def _record(
        self, port: _Described, data: bytes, time: float, flags: int, comment: str = ""
    ) -> None:
        self._check_writable()
        ticks = round(time * _MICROSECOND) - port.interface.tsoffset * _MICROSECOND
        if ticks < 0:
            # Ticks are unsigned: for times before 1970, or before 0 of a simulated clock,
            # another interface follows that counts from an earlier second.
            earlier = ticks // _MICROSECOND
            self._describe_interface(port, tsoffset=port.interface.tsoffset + earlier)
            ticks -= earlier * _MICROSECOND
        if abs(time - self._checked) >= 1:
            self._checked = time
            self._check_exists()
        for start in range(0, max(len(data), bool(comment)), _LARGEST_CHUNK):
            piece = bytes(data[start : start + _LARGEST_CHUNK])
            self._append(pcapng.EnhancedPacket(port.number, ticks, piece, flags, comment))

    def note(self, note: Note) -> None:
        """Write a note; the operating system has it on return.

        Raises `ValueError` for data that JSON can't hold.
        """
        block = block_of(note)
        with self._lock:
            self._check_writable()
            self._append(block)

    def discard_if_empty(self) -> None:
        """Close, and delete the file if nothing was recorded in it and it did not exist before."""
        if self._end == self._begun_at:
            self.discard()
        else:
            self.close()

    def discard(self) -> None:
        """Close, and delete the file if it did not exist before."""
        self.close()
        if self._made:
            with suppress(OSError):
                self.path.unlink()

    def close(self) -> None:
        """End the recording. A second call does nothing."""
        try:
            with self._lock:
                self._file.close()
        except OSError as error:
            raise capture_error(self.path, error) from error

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _open(self, *, overwrite: bool, pipe: bool) -> BinaryIO:
        exists = self.path.exists() and not self.path.is_dir()
        self._made = not exists
        if (overwrite or pipe) and exists and not self.path.is_file():
            return self.path.open("wb", buffering=0)
        file = self.path.open("r+b" if overwrite and exists else "xb", buffering=0)
        try:
            hold(file)
            if exists:  # not before: another program may be recording to it
                file.truncate(0)
        except BaseException:
            file.close()
            raise
        return file

    def _describe_interface(self, port: _Described, tsoffset: int) -> None:
        interface = replace(port.interface, tsoffset=tsoffset)
        self._append(interface)
        # Not before it is in the file: it defines a tick.
        port.interface, port.number = interface, self._interfaces
        self._interfaces += 1

    def _append(self, block: pcapng.Block) -> None:
        """Write the whole block, or nothing of it."""
        data = pcapng.encode(block)
        try:
            write_all(self._file, data)
            self._end += len(data)
        except BaseException as error:  # also Ctrl-C in the middle of a block
            try:
                self._file.truncate(self._end)
                self._file.seek(self._end)
            except OSError:
                self._broken = True
            if isinstance(error, OSError):
                raise capture_error(self.path, error) from error
            raise

    def _check_writable(self) -> None:
        if self._broken or self._file.closed:
            raise CaptureError(str(self.path), _OVER)

    def _check_exists(self) -> None:
        """Raise if the file was deleted: some systems let a writer write on without any effect."""
        with suppress(OSError):
            self.deleted = bool(self._links) and not os.fstat(self._file.fileno()).st_nlink
        if self.deleted:
            self._broken = True
            gone = system_error(errno.ENOENT)
            raise CaptureError(str(self.path), _DELETED).caused_by(gone, self.path)


def append_note(path: Path, *notes: Note) -> None:
    """Add notes to a recording that is not being written; whole, or not at all.

    `time` of each: as readers give the times of its last recording (`capture.dating`).
    Raises `CaptureError` if the file is no capture or can't be written.
    """
    CaptureReader(path)
    try:
        if is_packed(path):
            raise UnfitFile(errno.EINVAL, _PACKED)
        with open_regular(path, "r+b", buffering=0) as file:
            hold(file)
            found = index(file)
            last = len(found.sections) - 1
            seconds = shift_at_end(file) or corrections(found.notes).get(last, 0.0)
            file.seek(0)
            order = pcapng.BYTE_ORDERS.get(file.read(12)[8:]) or "<"
            end = file.seek(0, os.SEEK_END)
            try:
                added = (block_of(moved(note, -seconds)) for note in notes)
                write_all(file, b"".join(pcapng.encode(block, order) for block in added))
            except BaseException:  # Ctrl-C, too
                with suppress(OSError):
                    file.truncate(end)
                raise
    except MikasError:
        raise
    except OSError as error:
        raise capture_error(path, error, _READ_ONLY.get(error.errno or 0)) from error


def _not_begun(path: Path, error: OSError) -> CaptureError:
    """Return why there is no file to record to, and what to do."""
    return capture_error(path, error, _NOT_BEGUN.get(error.errno or 0))


_NOT_BEGUN: Final = {
    **dict.fromkeys(
        (errno.ENOENT, errno.ENOTDIR),
        Text(
            "its folder does not exist; make it, or choose another",
            "такой папки нет; создайте её или выберите другую",
        ),
    ),
    **dict.fromkeys(
        (errno.EACCES, errno.EPERM, errno.EROFS),
        Text(
            "the system does not let you write there; choose another folder, your own for one",
            "система не даёт писать туда; выберите другую папку, например свою домашнюю",
        ),
    ),
    **dict.fromkeys(FULL, Text("there is no room left", "места больше нет")),
    errno.ENAMETOOLONG: Text(
        "the name is too long; choose a shorter one", "имя длинное; выберите покороче"
    ),
}
_READ_ONLY: Final = dict.fromkeys(
    (errno.EACCES, errno.EPERM, errno.EROFS),
    Text(
        "it may only be read, so nothing can be added to it; copy it to where you may write",
        "файл только для чтения, и добавить в него ничего нельзя; скопируйте его туда, где можно "
        "писать",
    ),
)
_PACKED = Text(
    "it is packed, so nothing can be added to it; unpack it first",
    "файл сжат, и добавить в него ничего нельзя; сначала распакуйте его",
)
_DELETED = Text(
    "the file was deleted while being recorded; nothing more is kept",
    "файл удалён во время записи; больше ничего не сохраняется",
)
_OVER = Text(
    "the recording is over; nothing more is kept",
    "запись окончена; больше ничего не сохраняется",
)
