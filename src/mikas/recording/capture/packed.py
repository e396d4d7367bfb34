"""Unpack a recording that another program has packed, known by its first bytes, not by its name.

Python's own modules unpack gzip, bzip2, xz and zip, and Zstandard from 3.14 on. For the others the
error names the program. The result lies in a temporary file, of a bounded size: what was packed may
be anything. Of a cut file everything before the cut is read.
"""

from __future__ import annotations

import struct
import sys
import zlib
from collections.abc import Callable, Iterator
from errno import EINVAL
from functools import partial
from importlib import import_module
from typing import Any, BinaryIO, Final

from mikas.cancellation import check_cancelled
from mikas.errors import UnfitFile
from mikas.i18n import Text
from mikas.recording.capture.scan import LARGEST, Scanner, is_section_start
from mikas.recording.capture.temporary import temporary_capture

MOST: Final = (512 << 20) if sys.platform == "emscripten" else 2 << 30
"""Bytes that are unpacked; in a browser they lie in memory."""

_PIECE: Final = 1 << 16
_MEMORY: Final = 256 << 20  # bytes that xz may take
_ZIP: Final = b"PK\x03\x04"
_LOCAL: Final = struct.Struct("<4x2xHHHHIIIHH")  # a file's header in a zip
_PROGRAMS: Final = {
    b"\x1f\x8b": ("gzip", "gunzip"),
    b"BZh": ("bzip2", "bunzip2"),
    b"\xfd7zXZ\0": ("xz", "unxz"),
    b"\x5d\0\0": ("lzma", "unlzma"),
    _ZIP: ("zip", "unzip"),
    b"PK\x05\x06": ("zip", "unzip"),
    b"\x28\xb5\x2f\xfd": ("Zstandard", "unzstd"),
    b"\x04\x22\x4d\x18": ("LZ4", "lz4 -d"),
    b"\x02\x21\x4c\x18": ("LZ4", "lz4 -d"),
    b"7z\xbc\xaf\x27\x1c": ("7-Zip", "7z x"),
    b"Rar!\x1a\x07": ("RAR", "unrar x"),
    b"LZIP": ("lzip", "lzip -d"),
    b"\x1f\x9d": ("compress", "uncompress"),
    b"\x89LZO\0\r\n": ("lzop", "lzop -d"),
}
_TAR: Final = ("tar", "tar xf")
_BROKEN: Final = b"\xff" * 12  # no block: readers say that something is damaged
_CUT: Final = bytes(4)  # an unfinished block


SUFFIXES: Final = (".gz", ".bz2", ".xz", ".lzma", ".zip", ".zst", ".lz4", ".7z")


def packed_suffix(name: str) -> str:
    """Return what a packing program has put behind a recording's name, in small letters."""
    return next((suffix for suffix in SUFFIXES if name.lower().endswith(suffix)), "")


def packing_of(head: bytes) -> tuple[str, str] | None:
    """Return how a file with these first bytes is packed, and the program that unpacks it."""
    if head[257:262] == b"ustar":
        return _TAR
    return next((it for magic, it in _PROGRAMS.items() if head.startswith(magic)), None)


def unpacked(file: BinaryIO) -> BinaryIO | None:
    """Return the content of a packed `file` as a temporary file; None if it is not packed.

    Raises `UnfitFile` if it can't be unpacked here, or holds no recording, or several.
    """
    file.seek(0)
    head = file.read(512)
    file.seek(0)
    packing = packing_of(head)
    if packing is None:
        return None
    out = temporary_capture(partial(_write, _pieces(file, *packing), packing))
    out.seek(0)
    return out


def _write(pieces: Iterator[bytes], packing: tuple[str, str], out: BinaryIO) -> None:
    size, is_checked = 0, False
    try:
        for piece in pieces:
            check_cancelled()
            size += len(piece)
            if size > MOST:
                raise UnfitFile(EINVAL, _TOO_LARGE.filled(most=MOST >> 20))
            out.write(piece)
            if not is_checked and size >= _PIECE:
                is_checked = True
                _check(out, packing)
    except EOFError:
        out.write(_CUT)
    except (zlib.error, ValueError) as error:
        if "emory" in str(error):
            raise UnfitFile(EINVAL, _FOREIGN.filled(how=packing[0], program=packing[1])) from None
        out.write(_BROKEN)
    if not is_checked:
        _check(out, packing)


def _check(out: BinaryIO, packing: tuple[str, str]) -> None:
    """Raise `UnfitFile` if what was unpacked so far is no begin of a recording."""
    out.seek(0)
    head = out.read(512)
    if (inner := packing_of(head)) is not None:
        raise UnfitFile(EINVAL, _TWICE.filled(how=packing[0], program=packing[1], inner=inner[0]))
    if not is_section_start(head[:12]) and not Scanner(out, LARGEST).goes_on_as_one():
        raise UnfitFile(EINVAL, _NO_RECORDING.filled(how=packing[0]))
    out.seek(0, 2)


def _pieces(file: BinaryIO, how: str, program: str) -> Iterator[bytes]:
    """Yield the content. Raise `EOFError` where the file is cut."""
    try:
        match how:
            case "gzip":
                return _by(file, _Gzip)
            case "bzip2":
                return _by(file, import_module("bz2").BZ2Decompressor)
            case "xz" | "lzma":
                lzma = import_module("lzma")
                return _valued(
                    _by(file, lambda: lzma.LZMADecompressor(memlimit=_MEMORY)), lzma.LZMAError
                )
            case "Zstandard":
                zstd = import_module("compression.zstd")
                return _valued(_by(file, zstd.ZstdDecompressor), zstd.ZstdError)
            case "zip":
                return _in_zip(file)
    except ImportError:
        pass
    raise UnfitFile(EINVAL, _FOREIGN.filled(how=how, program=program))


def _valued(pieces: Iterator[bytes], kind: type[Exception]) -> Iterator[bytes]:
    """Yield the pieces; a module's own error becomes a `ValueError`."""
    try:
        yield from pieces
    except kind as error:
        raise ValueError(str(error)) from error


class _Gzip:
    """A decompressor of zlib with the methods of the others."""

    def __init__(self, bits: int = 31) -> None:
        self._inner = zlib.decompressobj(bits)
        self.needs_input = True

    @property
    def eof(self) -> bool:
        return self._inner.eof

    @property
    def unused_data(self) -> bytes:
        return self._inner.unused_data

    def decompress(self, data: bytes, max_length: int) -> bytes:
        found = self._inner.decompress(self._inner.unconsumed_tail + data, max_length)
        self.needs_input = not self._inner.unconsumed_tail and len(found) < max_length
        return found


def _by(file: BinaryIO, make: Callable[[], Any]) -> Iterator[bytes]:
    """Yield what a decompressor gives, of several streams one after the other."""
    inner, data = make(), b""
    while True:
        if inner.needs_input and not data:
            data = file.read(_PIECE)
            if not data:
                raise EOFError
        try:
            piece, data = inner.decompress(data, _PIECE), b""
        except OSError as error:  # of bz2
            raise ValueError(str(error)) from error
        if piece:
            yield piece
        if inner.eof:
            data = inner.unused_data or file.read(_PIECE)
            if not data.strip(b"\0"):  # the end, or a tape's padding
                return
            inner = make()


def _in_zip(file: BinaryIO) -> Iterator[bytes]:
    """Yield the only recording of a zip."""
    zipfile = import_module("zipfile")
    try:
        archive = zipfile.ZipFile(file)
        found = []
        for entry in archive.infolist():
            if entry.is_dir():
                continue
            if entry.flag_bits & 1:
                raise UnfitFile(EINVAL, _LOCKED)
            with archive.open(entry) as part:
                if is_section_start(part.read(12)):
                    found.append(entry)
    except (zipfile.BadZipFile, EOFError, zlib.error):
        return _in_cut_zip(file)
    except (NotImplementedError, RuntimeError):
        raise UnfitFile(EINVAL, _FOREIGN.filled(how="zip", program="7z x")) from None
    if not found:
        raise UnfitFile(EINVAL, _NO_RECORDING.filled(how="zip"))
    if len(found) > 1:
        names = ", ".join(entry.filename for entry in found[:10])
        raise UnfitFile(EINVAL, _SEVERAL.filled(count=len(found), names=names))
    return _of_entry(archive, found[0], zipfile.BadZipFile)


def _of_entry(archive: Any, entry: Any, broken: type[Exception]) -> Iterator[bytes]:  # noqa: ANN401
    with archive.open(entry) as part:
        try:
            while piece := part.read1(_PIECE):
                yield piece
        except broken as error:  # its checksum is another
            raise ValueError(str(error)) from error


def _in_cut_zip(file: BinaryIO) -> Iterator[bytes]:
    """Yield the first recording of a zip that has lost its table of contents."""
    at = 0
    while True:
        file.seek(at)
        head = file.read(_LOCAL.size)
        if len(head) < _LOCAL.size or not head.startswith(_ZIP):
            raise EOFError
        flags, method, *_, packed, _, name, extra = _LOCAL.unpack(head)
        begin = at + _LOCAL.size + name + extra
        if flags & 1:
            raise UnfitFile(EINVAL, _LOCKED)
        if method not in (0, 8):
            raise UnfitFile(EINVAL, _FOREIGN.filled(how="zip", program="7z x"))
        file.seek(begin)
        pieces = _by(file, lambda: _Gzip(-15)) if method else iter(lambda: file.read(_PIECE), b"")
        first = next(pieces, b"")
        if is_section_start(first[:12]):
            yield first
            yield from pieces
            raise EOFError
        if flags & 8:  # its size is behind it
            raise EOFError
        at = begin + packed


_FOREIGN: Final = Text(
    "the file is packed ({how}); unpack it first: `{program}`",
    "файл сжат ({how}); сначала распакуйте его: `{program}`",
)
_TWICE: Final = Text(
    "the file is packed twice ({how}, then {inner}); unpack it first: `{program}`",
    "файл сжат дважды ({how}, внутри {inner}); сначала распакуйте его: `{program}`",
)
_NO_RECORDING: Final = Text(
    "no recording of the line is packed in the file ({how})",
    "в сжатом файле ({how}) нет записи линии",
)
_SEVERAL: Final = Text(
    "the file holds {count} recordings ({names}); unpack it first: `unzip`",
    "в файле записей: {count} ({names}); сначала распакуйте его: `unzip`",
)
_LOCKED: Final = Text(
    "the file is locked by a password; unpack it first: `unzip`",
    "файл закрыт паролем; сначала распакуйте его: `unzip`",
)
_TOO_LARGE: Final = Text(
    "unpacked, the file has more than {most} MB: no recording of a line is that large",
    "в распакованном виде файл больше {most} МБ: таких записей линии не бывает",
)
