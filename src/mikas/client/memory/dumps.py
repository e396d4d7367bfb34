"""A dump: a memory space in a file, read block by block, resumable, verified by a second pass (§3).

The file is plain binary, the first byte at the first address. Its manifest `FILE.json` stands
beside it: space, range, unit, progress of both passes (rows 21–26). After an error or a pause the
next run continues at the first missing byte, in the second pass too. Fields were added to schema 1.
"""

from __future__ import annotations

import errno
import hashlib
import json
import os
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, BinaryIO, get_type_hints

from mikas.cleaning import clean_text, is_in_calendar
from mikas.client.ecu import Ecu
from mikas.client.memory.spaces import MemorySpace
from mikas.commands.base import check_range
from mikas.commands.unit import version_of, version_text
from mikas.errors import (
    MikasError,
    UsageError,
    naming_file,
    system_error,
    unusable_file,
    usage_error,
)
from mikas.files import beside, open_regular, read_json, read_regular
from mikas.files.locks import hold
from mikas.saving import save

SCHEMA = 1
MOST_BYTES = 1 << 20  # of a dump; the largest space has 64 KB
_MOST_MANIFEST = 1 << 16


@dataclass(slots=True)
class Manifest:
    """The description of a dump's file. `time`: the date of the last change.

    `verify`: a second pass is wanted; `checked`: its bytes so far; `differences`: the number found
    in them, None before its start; `verified`: whether it agreed, None before its end.
    """

    space: str
    first: int
    last: int
    model: str
    version_code: int
    passport: tuple[str, ...]
    bytes_read: int = 0
    complete: bool = False
    verified: bool | None = None
    sha256: str | None = None
    time: float = 0.0
    schema: int = SCHEMA
    verify: bool = False
    checked: int = 0
    differences: int | None = None

    @property
    def size(self) -> int:
        """The bytes of the complete range."""
        return self.last - self.first + 1

    @property
    def finished(self) -> bool:
        """Whether the dump is complete and a wanted second pass has ended."""
        return self.complete and (not self.verify or self.checked >= self.size)

    def set_bytes_read(self, count: int) -> None:
        """Set the bytes in the file; if some are missing, drop checksum and second pass."""
        self.bytes_read = min(self.size, count)
        if self.bytes_read < self.size:
            self.complete, self.verified, self.sha256 = False, None, None
            self.checked, self.differences = 0, None

    def as_json(self) -> dict[str, Any]:
        """Return the content of the manifest's file."""
        return {**asdict(self), "version_code": version_text(self.version_code)}


def manifest_path(file: Path) -> Path:
    """Return `dump.bin.json` for `dump.bin`."""
    return beside(file, ".json")


def read_manifest(file: Path) -> Manifest | None:
    """Return the manifest of `file`, None if missing. Raises `UsageError` for an invalid one."""
    path = manifest_path(file)
    if not os.path.lexists(path):
        return None
    try:
        stored = read_json(path, _MOST_MANIFEST)
        version_code = version_of(stored["version_code"])
        passport = tuple(stored["passport"])
        manifest = Manifest(**{**stored, "version_code": version_code, "passport": passport})
        _check(manifest)
    except OSError as error:
        raise unusable_file(path, error) from error
    except (ValueError, TypeError, KeyError) as error:
        raise file_error(path, "it is no manifest of a dump", "это не описание дампа") from error
    return manifest


def _check(manifest: Manifest) -> None:
    """Raise `TypeError` or `ValueError` for a value that can't be: the file may be anybody's."""
    kinds = get_type_hints(Manifest) | {"passport": tuple, "time": int | float}
    for name, kind in kinds.items():
        value = getattr(manifest, name)
        if not isinstance(value, kind) or (isinstance(value, bool) and kind is int):
            raise TypeError(name)
    if not all(isinstance(piece, str) for piece in manifest.passport):
        raise TypeError("passport")
    check_range(manifest.space, manifest.first, manifest.size)
    found, checked = manifest.differences, manifest.checked
    if not 0 <= checked <= manifest.size or (found is not None and found < 0):
        raise ValueError
    if manifest.bytes_read < 0 or not is_in_calendar(abs(manifest.time)):
        raise ValueError


def identity_of(ecu: Ecu) -> tuple[int, tuple[str, ...]]:
    """Return version code and passport as a manifest has them, which is cleaned when it is read."""
    return ecu.version_code, tuple(clean_text(piece) for piece in ecu.passport().pieces)


def read_dump(file: Path, *, follow: bool = False) -> bytes:
    """Return a dump's bytes. Raises `OSError` as `mikas.files`; `follow`: the user named it."""
    return read_regular(file, MOST_BYTES, follow=follow)


def file_error(file: Path, en: str, ru: str) -> UsageError:
    """Return the error for `file`."""
    return usage_error(f"{file}: {en}", f"{file}: {ru}")


Progress = Callable[[int], None]  # gets the number of bytes done since the last call


@dataclass(frozen=True, slots=True)
class Difference:
    """Two different bytes at one address; None: one side has no byte at it."""

    address: int
    a: int | None
    b: int | None


class Dump:
    """One dump into one file. `advance()` reads the missing bytes; any block may be the last."""

    def __init__(
        self, ecu: Ecu, space: MemorySpace, file: Path, *, first: int, last: int, resume: bool
    ) -> None:
        if last < first:
            raise usage_error(
                f"the last address, {last:04X}, is before the first, {first:04X}",
                f"последний адрес, {last:04X}, меньше первого, {first:04X}",
            )
        check_range(space.name, first, last - first + 1)
        self._ecu = ecu
        self._space = space
        self._file = file
        self.manifest: Manifest = Manifest(
            space.name, first, last, ecu.model.text.en, *identity_of(ecu)
        )
        if os.path.lexists(file) or os.path.lexists(manifest_path(file)):
            if not resume:
                there = file_error(
                    file,
                    "it exists already; choose another name, or --resume to go on with it",
                    "такой файл уже есть; выберите другое имя или продолжите его: --resume",
                )
                raise there.caused_by(system_error(errno.EEXIST), file)
            self._resume()

    def _resume(self) -> None:
        stored, wanted = read_manifest(self._file), self.manifest
        begun = stored is None or stored.bytes_read
        there = os.path.lexists(self._file)
        if not there and begun:  # else killed between the manifest and the file
            gone = self._error(
                "the file is gone, only its manifest is left; delete that too to begin anew",
                "самого файла нет, осталось только описание; чтобы начать заново, удалите и его",
            )
            raise gone.caused_by(system_error(errno.ENOENT), self._file)
        if stored is None:
            raise self._error(
                "it has no manifest beside it, so it can't be resumed",
                "рядом с ним нет описания, продолжить нельзя",
            )
        if (stored.space, stored.first, stored.last) != (wanted.space, wanted.first, wanted.last):
            place = f"{stored.space} {stored.first:04X}–{stored.last:04X}"
            raise self._error(f"it is a dump of {place}", f"это дамп {place}")
        if (stored.version_code, stored.passport) != (wanted.version_code, wanted.passport):
            raise self._error(
                "it was begun on another unit (its passport differs)",
                "он начат на другом блоке (паспорт не тот)",
            )
        size = 0
        if there:
            with naming_file(self._file), open_regular(self._file, "r+b") as file:
                size = file.seek(0, os.SEEK_END)
        if size > wanted.size:
            raise self._error(
                "it is longer than its manifest says, so it is another file",
                "он длиннее, чем сказано в описании, значит это другой файл",
            )
        stored.set_bytes_read(size)
        self.manifest = replace(stored, model=wanted.model, schema=SCHEMA)

    def _error(self, en: str, ru: str) -> UsageError:
        return file_error(self._file, en, ru)

    def advance(self, *, block: int | None, progress: Progress) -> None:
        """Read the missing bytes. Bytes read before an error stay in the file."""
        manifest = self.manifest
        missing = manifest.size - manifest.bytes_read
        start = manifest.first + manifest.bytes_read
        blocks = self._space.blocks(start, missing, block) if missing else ()
        try:
            self._write_manifest()  # before the file: without it no byte could be resumed
            with self._opened() as out:
                hold(out)  # another program may be reading the same dump
                out.truncate(manifest.bytes_read)
                out.seek(manifest.bytes_read)
                for data in blocks:
                    out.write(data)
                    out.flush()
                    manifest.bytes_read += len(data)
                    progress(len(data))
                manifest.complete = True
        except MikasError:  # some are OSErrors as well, as those of the line
            raise
        except OSError as error:
            raise unusable_file(self._file, error) from error
        finally:
            self._write_manifest()

    def _opened(self) -> BinaryIO:
        try:
            return open_regular(self._file, "r+b")
        except FileNotFoundError:
            return self._file.open("xb")  # never through a link

    def verify(self, *, block: int | None, progress: Progress) -> list[Difference]:
        """Make a second pass over the whole range; return the differences from the first."""
        manifest = self.manifest
        manifest.verified, manifest.checked, manifest.differences = None, 0, None
        return self.check(manifest.size, block=block, progress=progress)

    def check(self, most: int, *, block: int | None, progress: Progress) -> list[Difference]:
        """Check the next `most` bytes in the second pass; return the differences from the first."""
        manifest = self.manifest
        with naming_file(self._file), open_regular(self._file) as file:
            file.seek(manifest.checked)
            data = file.read(most)
        first = manifest.first + manifest.checked
        found = list(compare(self._space, data, first, block, progress))
        manifest.verify = True
        manifest.checked += len(data)
        manifest.differences = (manifest.differences or 0) + len(found)
        if manifest.checked >= manifest.size:
            manifest.verified = manifest.differences == 0
        self._write_manifest()
        return found

    def _write_manifest(self) -> None:
        manifest, path = self.manifest, manifest_path(self._file)
        manifest.time = round(self._ecu.tester.link.date(), 6)
        with naming_file(path):
            if manifest.complete:
                manifest.sha256 = hashlib.sha256(read_dump(self._file)).hexdigest()
            text = json.dumps(manifest.as_json(), ensure_ascii=False, indent=1)
            save(path, text + "\n")


def compare(
    space: MemorySpace, data: bytes, first: int, block: int | None, progress: Progress
) -> Iterator[Difference]:
    """Yield the differences of the unit's memory (`a`) from `data` (`b`), from `first` on."""
    address = first
    for part in space.blocks(first, len(data), block):
        stored = data[address - first : address - first + len(part)]
        for offset, (a, b) in enumerate(zip(part, stored, strict=True)):
            if a != b:
                yield Difference(address + offset, a, b)
        address += len(part)
        progress(len(part))


def differences(a: bytes, first_a: int, b: bytes, first_b: int) -> Iterator[Difference]:
    """Yield the differences of two dumps by address."""
    for address in range(min(first_a, first_b), max(first_a + len(a), first_b + len(b))):
        in_a, in_b = address - first_a, address - first_b
        left = a[in_a] if 0 <= in_a < len(a) else None
        right = b[in_b] if 0 <= in_b < len(b) else None
        if left != right:
            yield Difference(address, left, right)
