"""A dump: a memory space in a file, read block by block, resumable, verified by a second pass (§3).

The file is plain binary, the first byte at the first address. Its manifest `FILE.json` stands
beside it: space, range, unit, progress of both passes (rows 21–26). After an error or a pause the
next run continues at the first missing byte, in the second pass too. Fields were added to schema 1.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from mikas.client.ecu import Ecu
from mikas.client.memory import MemorySpace, last_of
from mikas.commands.base import check_range
from mikas.errors import UsageError, reason_at
from mikas.i18n import Text

SCHEMA = 1


@dataclass(slots=True)
class Manifest:
    """What a dump's file holds. `time`: the link's clock at its last change.

    `verify`: a second pass is wanted; `checked`: its bytes so far; `differences`: what it found in
    them, None before it has begun; `verified`: whether it agreed, None before its end. A manifest
    without these three is of an older program.
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
        """Bytes of the whole."""
        return self.last - self.first + 1

    @property
    def finished(self) -> bool:
        """Whether nothing is left to do: the second pass, if it is wanted, has ended too."""
        return self.complete and (not self.verify or self.checked >= self.size)

    def holds(self, count: int) -> None:
        """The file has so many bytes. What was said of a longer one is true no more."""
        self.bytes_read = min(self.size, count)
        if self.bytes_read < self.size:
            self.complete, self.verified, self.sha256 = False, None, None
            self.checked, self.differences = 0, None

    def as_json(self) -> dict[str, Any]:
        """As it stands in the file."""
        return asdict(self)


def manifest_path(file: Path) -> Path:
    """`dump.bin` → `dump.bin.json`."""
    return file.with_name(file.name + ".json")


def read_manifest(file: Path) -> Manifest | None:
    """The manifest of `file`; None if there is none. Raises `UsageError` if it is not one."""
    path = manifest_path(file)
    if not path.exists():
        return None
    try:
        stored = json.loads(path.read_text("utf-8"))
        manifest = Manifest(**{**stored, "passport": tuple(stored["passport"])})
        check_range(manifest.space, last_of(manifest.space), manifest.first, manifest.size)
        _read_second_pass(manifest)
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise wrong(path, "it is no manifest of a dump", "это не описание образа") from error
    return manifest


def _read_second_pass(manifest: Manifest) -> None:
    """Raises `ValueError`, `TypeError`. An older program kept only whether the second pass agreed:
    if it did not, the number is not known, so it is to be made again.
    """
    found, checked = manifest.differences, manifest.checked
    if not isinstance(checked, int) or not isinstance(found, int | None):
        raise TypeError
    if not 0 <= checked <= manifest.size or (found is not None and found < 0):
        raise ValueError
    manifest.verify = bool(manifest.verify) or manifest.verified is not None
    if found is not None:
        return
    if manifest.verified is True:
        manifest.differences, manifest.checked = 0, manifest.size
    else:
        manifest.checked = 0


def wrong(file: Path, en: str, ru: str) -> UsageError:
    """What is not right about `file`."""
    return UsageError(problem=Text(f"{file}: {en}", f"{file}: {ru}"))


Progress = Callable[[int], None]  # told how many more bytes are done


@dataclass(frozen=True, slots=True)
class Difference:
    """Two bytes at one address that differ; None: one side has no byte there."""

    address: int
    a: int | None
    b: int | None


class Dump:
    """One dump into one file. `advance()` reads on; it can be left at any block."""

    def __init__(
        self, ecu: Ecu, space: MemorySpace, file: Path, *, first: int, last: int, resume: bool
    ) -> None:
        check_range(space.name, space.last, first, last - first + 1)
        self._ecu = ecu
        self._space = space
        self._file = file
        self.manifest = Manifest(
            space.name, first, last, ecu.model.text.en, ecu.version_code, ecu.passport().pieces
        )
        if file.exists() or manifest_path(file).exists():
            if not resume:
                raise wrong(
                    file,
                    "it exists already; choose another name, or --resume to go on with it",
                    "такой файл уже есть; выберите другое имя или продолжите его: --resume",
                )
            self._go_on()

    def _go_on(self) -> None:
        stored, wanted = read_manifest(self._file), self.manifest
        if not self._file.exists():
            raise wrong(
                self._file,
                "the file is gone, only its manifest is left; delete that too to begin anew",
                "самого файла нет, осталось только описание; чтобы начать заново, удалите и его",
            )
        if stored is None:
            raise wrong(
                self._file,
                "it has no manifest beside it, so it can't be resumed",
                "рядом с ним нет описания, продолжить нельзя",
            )
        if (stored.space, stored.first, stored.last) != (wanted.space, wanted.first, wanted.last):
            raise wrong(
                self._file,
                f"it is a dump of {stored.space} {stored.first:04X}–{stored.last:04X}",
                f"это образ {stored.space} {stored.first:04X}–{stored.last:04X}",
            )
        if (stored.version_code, stored.passport) != (wanted.version_code, wanted.passport):
            raise wrong(
                self._file,
                "it was begun on another unit (its passport differs)",
                "он начат на другом блоке (паспорт не тот)",
            )
        if self._file.stat().st_size > wanted.size:
            raise wrong(
                self._file,
                "it is longer than its manifest says, so it is another file",
                "он длиннее, чем сказано в описании, значит это другой файл",
            )
        stored.holds(self._file.stat().st_size)
        self.manifest = replace(
            wanted,
            bytes_read=stored.bytes_read,
            complete=stored.complete,
            verified=stored.verified,
            verify=stored.verify,
            checked=stored.checked,
            differences=stored.differences,
        )

    def advance(self, *, block: int | None, progress: Progress) -> None:
        """Reads what is still missing. What was read before an error stays in the file."""
        manifest = self.manifest
        try:
            with self._file.open("r+b" if self._file.exists() else "wb") as out:
                out.truncate(manifest.bytes_read)
                out.seek(manifest.bytes_read)
                self._note()
                missing = manifest.size - manifest.bytes_read
                start = manifest.first + manifest.bytes_read
                for data in self._space.blocks(start, missing, block) if missing else ():
                    out.write(data)
                    out.flush()
                    manifest.bytes_read += len(data)
                    progress(len(data))
                manifest.complete = True
        except OSError as error:
            if isinstance(error, ConnectionError | TimeoutError):
                raise
            raise UsageError(problem=reason_at(self._file, error)) from error
        finally:
            self._note()

    def verify(self, *, block: int | None, progress: Progress) -> list[Difference]:
        """A second pass over all of it; returns where it differs from the first."""
        manifest = self.manifest
        manifest.verified, manifest.checked, manifest.differences = None, 0, None
        return self.check(manifest.size, block=block, progress=progress)

    def check(self, most: int, *, block: int | None, progress: Progress) -> list[Difference]:
        """The next `most` bytes of the second pass; returns where they differ from the first."""
        manifest = self.manifest
        with self._file.open("rb") as file:
            file.seek(manifest.checked)
            data = file.read(most)
        first = manifest.first + manifest.checked
        found = list(compare(self._space, data, first, block, progress))
        manifest.verify = True
        manifest.checked += len(data)
        manifest.differences = (manifest.differences or 0) + len(found)
        if manifest.checked >= manifest.size:
            manifest.verified = manifest.differences == 0
        self._note()
        return found

    def _note(self) -> None:
        manifest = self.manifest
        manifest.time = round(self._ecu.tester.link.now(), 6)
        if manifest.complete:
            manifest.sha256 = hashlib.sha256(self._file.read_bytes()).hexdigest()
        path = manifest_path(self._file)
        try:
            text = json.dumps(manifest.as_json(), ensure_ascii=False, indent=1)
            path.write_text(text + "\n", "utf-8")
        except OSError as error:
            raise UsageError(problem=reason_at(path, error)) from error


def compare(
    space: MemorySpace, data: bytes, first: int, block: int | None, progress: Progress
) -> Iterator[Difference]:
    """Where the unit's memory (`a`) differs from `data` (`b`), which begins at `first`."""
    address = first
    for part in space.blocks(first, len(data), block):
        stored = data[address - first : address - first + len(part)]
        for offset, (a, b) in enumerate(zip(part, stored, strict=True)):
            if a != b:
                yield Difference(address + offset, a, b)
        address += len(part)
        progress(len(part))


def differences(a: bytes, first_a: int, b: bytes, first_b: int) -> Iterator[Difference]:
    """Where two dumps differ, by address."""
    for address in range(min(first_a, first_b), max(first_a + len(a), first_b + len(b))):
        in_a, in_b = address - first_a, address - first_b
        left = a[in_a] if 0 <= in_a < len(a) else None
        right = b[in_b] if 0 <= in_b < len(b) else None
        if left != right:
            yield Difference(address, left, right)
