"""A memory space to a file: block by block, resumable, checked by a second pass (§3, rows 21–26).

The file is plain binary, the first byte at the first address. Beside it `FILE.json`, its manifest,
says what the file is: space, range, unit, whether it is complete, whether a second pass agreed.
What was read stays in the file whatever happens, and the next run goes on behind it; so does a
second pass, whose findings stand in the manifest.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from mikas.client.ecu import Ecu
from mikas.client.memory.manifest import Manifest, manifest_path, read_manifest, wrong
from mikas.client.memory.spaces import MemorySpace
from mikas.commands.base import check_range
from mikas.errors import UsageError, reason_at

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
