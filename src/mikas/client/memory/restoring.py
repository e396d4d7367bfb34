"""A dump written back to the unit: compared first, only different bytes are written and read back.

An interrupted restore leaves `FILE.restore.json` beside the dump, so that the next one knows that
the unit has a part of it. Resuming compares the whole range again: the unit's bytes decide, not the
file. Bytes count as written once they were read back.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path

from mikas import unkept
from mikas.client.ecu import Ecu
from mikas.client.memory import dumps
from mikas.client.memory.spaces import MemorySpace, Run
from mikas.commands import LARGEST_BLOCK
from mikas.commands.base import check_range
from mikas.errors import ReadBackDiffers, UsageError, hex_dump, naming_file
from mikas.files import beside
from mikas.i18n import Text
from mikas.saving import save

_PLACES_SHOWN = 6
_HOPELESS = 3  # runs of which no byte was taken; then the others are not tried
_NOT_WRITABLE = Text(
    "The unit accepts the writes and keeps its bytes: this memory can't be written in this way. "
    "Nothing was changed.",
    "Блок принимает запись, но байты остаются прежними: эта память так не записывается. Ничего не "
    "изменено.",
)
_STATE_STAYS = Text(
    "{place} can't be deleted ({why}): the next restore of this dump asks for --resume, though "
    "this one has ended.",
    "{place} не удаляется ({why}): следующая запись этого дампа попросит --resume, хотя эта "
    "завершена.",
)


@dataclass(frozen=True, slots=True)
class DumpFile:
    """A dump to write back. `manifest` None: without, or with one to be ignored."""

    path: Path
    first: int
    data: bytes
    manifest: dumps.Manifest | None

    @property
    def changed(self) -> bool:
        """Whether the file is no longer as it was read from the unit."""
        known = self.manifest.sha256 if self.manifest else None
        return known is not None and hashlib.sha256(self.data).hexdigest() != known

    @classmethod
    def read(
        cls, path: Path, space: str, *, first: int | None = None, ignore_manifest: bool = False
    ) -> DumpFile:
        """Read the dump and its manifest. Raises `UsageError` unless both fit `space`.

        `first`: the first address, for `ignore_manifest` only.
        """
        with naming_file(path):
            data = dumps.read_dump(path, follow=True)
        if not data:
            raise dumps.file_error(path, "the file is empty", "файл пуст")
        if ignore_manifest:
            if first is None:
                raise dumps.file_error(
                    path,
                    "without its manifest the first address is unknown: give it by --from",
                    "без описания неизвестен первый адрес: укажите --from",
                )
            check_range(space, first, len(data))
            return cls(path, first, data, None)
        manifest = _fitting_manifest(path, space, len(data))
        if first not in (None, manifest.first):
            raise dumps.file_error(
                path,
                f"its first address is {manifest.first:04X}, by its manifest; another one takes "
                "--ignore-manifest",
                f"по описанию первый адрес {manifest.first:04X}; другой — только с "
                "--ignore-manifest",
            )
        return cls(path, manifest.first, data, manifest)

    def check_unit(self, ecu: Ecu) -> None:
        """Raise `UsageError` if the dump was read from another unit."""
        manifest = self.manifest
        if manifest is None:
            return
        if (manifest.version_code, manifest.passport) != dumps.identity_of(ecu):
            named = " · ".join(piece for piece in manifest.passport if piece) or manifest.model
            raise dumps.file_error(
                self.path,
                f"it was read from another unit ({named}); to restore it all the same: "
                "--ignore-manifest --from ADDR",
                f"он считан из другого блока ({named}); всё равно записать: --ignore-manifest "
                "--from ADDR",
            )


def _fitting_manifest(path: Path, space: str, size: int) -> dumps.Manifest:
    manifest = dumps.read_manifest(path)
    if manifest is None:
        raise dumps.file_error(
            path,
            "it has no manifest beside it, so its unit and its first address are unknown; to "
            "restore it all the same: --ignore-manifest --from ADDR",
            "рядом с ним нет описания: неизвестны блок и первый адрес; всё равно записать: "
            "--ignore-manifest --from ADDR",
        )
    if manifest.space != space:
        raise dumps.file_error(
            path,
            f"it is a dump of {manifest.space}, not of {space}",
            f"это дамп {manifest.space}, а не {space}",
        )
    if manifest.size != size:
        raise dumps.file_error(
            path,
            f"it has {size} bytes, its manifest says {manifest.size}: an unfinished dump or "
            "another file; to restore it all the same: --ignore-manifest --from ADDR",
            f"в нём байтов {size}, а по описанию {manifest.size}: дамп не дочитан или это другой "
            "файл; всё равно записать: --ignore-manifest --from ADDR",
        )
    return manifest


class Restore:
    """One restore of `dump` into `space`: `compare`, then `write`.

    `written`: bytes written and read back; `differences`: bytes that keep another value (`a`) than
    the dump's (`b`); `is_interrupted`: writing was started and not ended.
    """

    def __init__(self, ecu: Ecu, space: MemorySpace, dump: DumpFile, *, resume: bool) -> None:
        dump.check_unit(ecu)
        self._ecu = ecu
        self._space = space
        self._dump = dump
        self._state = beside(dump.path, ".restore.json")
        self.runs: tuple[Run, ...] = ()
        self.written: int = 0
        self.differences: list[dumps.Difference] = []
        self.is_interrupted: bool = False
        if os.path.lexists(self._state) and not resume:
            raise dumps.file_error(
                dump.path,
                "a restore of it was interrupted; --resume compares again and goes on "
                f"({self._state.name} has its state)",
                "его запись была прервана; --resume сравнит заново и продолжит "
                f"(состояние — в {self._state.name})",
            )

    @property
    def different(self) -> int:
        """The bytes that differed before the restore."""
        return sum(len(run.data) for run in self.runs)

    @property
    def same(self) -> int:
        """The bytes that were the same before the restore."""
        return len(self._dump.data) - self.different

    def compare(self, *, block: int | None, progress: dumps.Progress) -> None:
        """Read the unit's bytes; find the `runs` to write, of at most `block` bytes each."""
        dump = self._dump
        found = dumps.compare(self._space, dump.data, dump.first, block, progress)
        self.runs = tuple(_runs(list(found), block or LARGEST_BLOCK))

    def write(self) -> Iterator[int]:
        """Write the runs, with one confirmation; yield the bytes of each that is done.

        Raises `NotConfirmed` before the first, `ReadBackDiffers` if the unit keeps all its bytes,
        and the errors of `MemorySpace.write_runs`; `compare` and `write` may follow again then.
        """
        if not self.runs:
            self._end()
            return
        writing = self._space.write_runs(self.runs, self._what())
        self._save()
        self.is_interrupted = True
        for number, (run, written) in enumerate(zip(self.runs, writing, strict=True), 1):
            self._count(run, written.after)
            # An earlier state is there, and says the same: resuming compares all bytes.
            with suppress(UsageError):
                self._save()
            if not self.written and number == min(_HOPELESS, len(self.runs)):
                self._end()
                raise ReadBackDiffers(
                    name=f"{self._space.name} {run.address:04X}",
                    wanted=hex_dump(run.data),
                    got=hex_dump(written.after),
                    advice=_NOT_WRITABLE,
                )
            yield len(run.data)
        self._end()

    def _end(self) -> None:
        with unkept.saying_once(_STATE_STAYS, self._state):
            self._state.unlink(missing_ok=True)
        self.is_interrupted = False

    def _count(self, run: Run, after: bytes) -> None:
        for offset, (a, b) in enumerate(zip(after, run.data, strict=True)):
            if a == b:
                self.written += 1
            else:
                self.differences.append(dumps.Difference(run.address + offset, a, b))

    def _what(self) -> Text:
        first = self._dump.first
        last = first + len(self._dump.data) - 1
        places = list(_places(self.runs))
        shown, more = ", ".join(places[:_PLACES_SHOWN]), len(places) - _PLACES_SHOWN
        return Text(
            "restore {space} {first:04X}–{last:04X}: of {size} bytes {count} differ ({places}{en})",
            "записать дамп в {space} {first:04X}–{last:04X}: из {size} байт отличаются {count} "
            "({places}{ru})",
        ).filled(
            space=self._space.name,
            first=first,
            last=last,
            size=len(self._dump.data),
            count=self.different,
            places=shown,
            en=f" and {more} more places" if more > 0 else "",
            ru=f" и ещё мест: {more}" if more > 0 else "",
        )

    def _save(self) -> None:
        """Write the state. Raises `UsageError`."""
        state = {
            "space": self._space.name,
            "first": self._dump.first,
            "last": self._dump.first + len(self._dump.data) - 1,
            "version_code": self._ecu.version_code,
            "passport": self._ecu.passport().pieces,
            "different": self.different,
            "written": self.written,
            "time": round(self._ecu.tester.link.date(), 6),
            "schema": dumps.SCHEMA,
        }
        with naming_file(self._state):
            save(self._state, json.dumps(state, ensure_ascii=False, indent=1) + "\n")


def _runs(found: Sequence[dumps.Difference], longest: int) -> Iterator[Run]:
    """Yield the neighbouring differences as runs of at most `longest` bytes."""
    start = 0
    for end in range(1, len(found) + 1):
        adjoins = end < len(found) and found[end].address == found[end - 1].address + 1
        if adjoins and end - start < longest:
            continue
        part = found[start:end]
        before = bytes(d.a for d in part if d.a is not None)
        data = bytes(d.b for d in part if d.b is not None)
        yield Run(part[0].address, before, data)
        start = end


def _places(runs: Sequence[Run]) -> Iterator[str]:
    """Yield `0040–0043` or `0040` for each place; neighbouring runs are one."""
    first = None
    for run, following in zip_longest(runs, runs[1:]):
        first = run.address if first is None else first
        end = run.address + len(run.data)
        if following is None or following.address != end:
            yield f"{first:04X}" if end == first + 1 else f"{first:04X}–{end - 1:04X}"
            first = None
