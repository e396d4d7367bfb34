"""Opening a capture: the reasons why a file is none, and the reading of other files in its place.

A packed file is unpacked (`packed`), and what other tools have merged is separated
(`separation`); notes whose packets were shifted follow them (`note_times`); streams without their
request get it from a plan (`cut_streams`). All readers open a capture here, and meet one port in a
section.
"""

from __future__ import annotations

import errno
import os
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from pathlib import Path
from shutil import copyfileobj
from typing import TYPE_CHECKING, BinaryIO, Final

from mikas.errors import (
    CaptureError,
    DiskFull,
    MikasError,
    UnfitFile,
)
from mikas.errors import reason_of as system_reason_of
from mikas.files import open_regular
from mikas.i18n import Text
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.edited.cut_streams import CutStreams
from mikas.recording.capture.edited.marks import changed, marked
from mikas.recording.capture.edited.note_times import NoteTimes, with_moved_notes
from mikas.recording.capture.edited.separation import MergeSearch, separated
from mikas.recording.capture.packed import packing_of, unpacked
from mikas.recording.capture.scan import LARGEST, Scanner, Unreadable, is_section_start, scan

if TYPE_CHECKING:
    from collections.abc import Iterator

_CLASSIC_PCAP: Final = ("a1b2c3d4", "d4c3b2a1", "a1b23c4d", "4d3cb2a1", "a1b2cd34", "34cdb2a1")


@contextmanager
def opened_capture(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """Open a capture at its begin. Raises `CaptureError` as `CaptureReader` does."""
    with opened(path) as file:
        if problem := _problem(file):
            raise CaptureError(str(Path(path)), problem, 0)
        file.seek(0)
        yield file


@contextmanager
def opened(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """Open a capture that may be none, with the recordings in it apart."""
    with _plain(path) as plain, ExitStack() as temporary:
        file, found = plain, _Search(plain)
        if found.merged.found:
            file = temporary.enter_context(separated(file))
            found = _Search(file)
        if found.times.is_shifted:
            file = temporary.enter_context(with_moved_notes(file, found.times))
            found = _Search(file)
        if found.streams.changes:
            file = temporary.enter_context(changed(file, found.streams.changes))
        file.seek(0)
        yield file


class _Search:
    """What other tools have done to a file."""

    def __init__(self, file: BinaryIO) -> None:
        self.merged, self.times, self.streams = MergeSearch(), NoteTimes(file), CutStreams(file)
        for raw, item in marked(file):
            self.merged.add(item)
            self.times.add(raw, item)
            self.streams.add(raw, item)
        self.times.finish()
        self.streams.finish()


@contextmanager
def _plain(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """Open a file, unpacked if it is packed."""
    try:
        with open_regular(Path(path), follow=True, buffering=0) as file:
            plain = unpacked(file)
            with plain or nullcontext(file) as ready:
                yield ready
    except MikasError:  # some are OSErrors as well: of whoever reads the file
        raise
    except OSError as error:
        raise capture_error(path, error) from error


def is_packed(path: str | os.PathLike[str]) -> bool:
    """Return whether a file is packed: it can be read, but nothing can be added to it."""
    with open_regular(Path(path), follow=True, buffering=0) as file:
        return packing_of(file.read(512)) is not None


def copy_plain(path: Path, out: Path) -> Path:
    """Write a packed recording as it is without packing; return `out`. Raises `CaptureError`."""
    with ExitStack() as closing:
        file = closing.enter_context(_plain(path))
        copyfileobj(file, closing.enter_context(out.open("wb")))
    return out


def _problem(file: BinaryIO) -> Text | None:
    """Return why the file is no capture; None if it is one."""
    head = file.read(12)
    if not head:
        return _EMPTY
    if not is_section_start(head):
        if head[:4].hex() in _CLASSIC_PCAP:
            return _CLASSIC
        if not Scanner(file, LARGEST).goes_on_as_one():
            return _NOT_PCAPNG
    other = _foreign_link_type(file)
    return None if other is None else _OTHER_LINK_TYPE.filled(type=other)


def _foreign_link_type(file: BinaryIO) -> int | None:
    """Return the link type if only other interfaces are described before the first packet."""
    other = None
    for item in scan(file):
        if isinstance(item, Unreadable):
            continue
        if item.kind in (pcapng.ENHANCED, pcapng.SIMPLE):
            break
        with suppress(pcapng.Malformed):
            block = pcapng.parse(item.kind, item.body, item.order)
            if isinstance(block, pcapng.Interface):
                if block.link_type == pcapng.LINKTYPE_USER0:
                    return None
                other = block.link_type
    return other


def reason_of(error: OSError) -> Text:
    """Return why a file could not be read or written, for a person."""
    if isinstance(error, UnfitFile):
        return error.text
    return _REASONS.get(error.errno or 0, system_reason_of(error))


def capture_error(
    path: str | os.PathLike[str], error: OSError, why: Text | None = None
) -> CaptureError:
    """Return the error of a capture that could not be read or written. `why`: if not as usual."""
    kind = DiskFull if error.errno in FULL else CaptureError
    return kind(os.fspath(path), why or reason_of(error)).caused_by(error, path)


_EMPTY = Text("the file is empty", "файл пуст")
_NOT_PCAPNG = Text(
    "this is not a recording of the line (a capture in pcapng); recordings are made on the Live "
    "screen (key R), by `mikas log -o FILE.pcapng` or by `--capture`",
    "это не запись линии (pcapng); записи делаются на экране «Приборы» (клавиша R), командой "
    "`mikas log -o ФАЙЛ.pcapng` или ключом `--capture`",
)
_CLASSIC = Text(
    "this is a capture in the old pcap format, which does not say who sent what; "
    "only pcapng can be read",
    "это запись в старом формате pcap, где не указано, кто что послал; читается только pcapng",
)
_OTHER_LINK_TYPE = Text(
    "this is a pcapng of another kind (link type {type}); a K-Line capture has 147",
    "это pcapng другого рода (тип канала {type}); у записи K-Line он 147",
)
FULL: Final = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_REASONS: Final = {
    **dict.fromkeys(
        FULL,
        Text(
            "there is no room left; what was recorded so far is whole",
            "места больше нет; записанное до сих пор цело",
        ),
    ),
    errno.EEXIST: Text(
        "the file exists already; choose another name",
        "файл уже есть; выберите другое имя",
    ),
    errno.ENOENT: Text("no such file or folder", "нет такого файла или папки"),
    errno.EISDIR: Text("this is a folder; name a file in it", "это папка; укажите файл в ней"),
}
