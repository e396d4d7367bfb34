"""What stands beside a dump's file, and how it is read again; fields were added to schema 1."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from mikas.client.memory.spaces import last_of
from mikas.commands.base import check_range
from mikas.errors import UsageError
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
