"""The work on one file, in any process or on any computer: read, interpret, write its tables.

It needs the file's URL, the dataset's, and the settings; it keeps nothing and raises nothing that
comes of the file. The files that it writes count only when `adding` has entered them in the ledger.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Final

from mikas.cleaning import without_secrets
from mikas.errors import (
    CaptureError,
    FleetError,
    MikasError,
    UnfitFile,
    reason_of,
    refusal_of,
    refused_number,
)
from mikas.errors.system import OF_PLACE
from mikas.files import open_regular
from mikas.fleet.entries import (
    FOLDER,
    HEADS,
    LONGEST,
    STEP,
    SUFFIX,
    LedgerEntry,
    parse_entry,
    stamp_of,
)
from mikas.fleet.ledger import MARKER
from mikas.fleet.places import FoundFile, as_local, is_of_file, shown
from mikas.fleet.stores import Store, store
from mikas.i18n import Text
from mikas.recording.capture.reader import CaptureReader

if TYPE_CHECKING:
    from mikas.fleet.interpreting import InterpretingSettings

_BLOCK: Final = 1 << 20
HEAD: Final = HEADS * STEP
"""Bytes by which recordings are found that may be states of one, compared step by step."""

LARGEST: Final = 2 << 30
"""Bytes of a recording; a line at 9600 baud makes some 200 MB in a day and night."""

_TOO_LARGE: Final = Text(
    "the file has more than {most} GB: no recording of a line is that large",
    "файл больше {most} ГБ: таких записей линии не бывает",
).filled(most=LARGEST >> 30)
_NOT_SEEN: Final = Text(
    "the computer that does the work does not see this dataset; use a place that every computer "
    "reaches by the same name",
    "компьютер, выполняющий работу, этого набора не видит; возьмите место, доступное всем "
    "компьютерам под одним именем",
)
_BUG: Final = Text(
    "this is a bug in mikas ({kind}); please report it with the file",
    "это ошибка в программе mikas ({kind}); сообщите о ней, приложив файл",
)


@dataclass(frozen=True, slots=True)
class FileOutcome:
    """What became of a file. `entry`: of its recording; `is_new`: its tables were written now;
    without an entry: `bad`, why nothing was read; `ends`: it would be the same for every other
    file; `opening`: its first `HEAD` bytes, if it is new.
    """

    file: FoundFile
    entry: LedgerEntry | None = None
    is_new: bool = False
    bad: Text | None = None
    ends: bool = False
    opening: bytes = b""


def work(
    file: FoundFile,
    dataset: str,
    settings: InterpretingSettings,
    run: str = "",
    *,
    redo: bool = False,
) -> FileOutcome:
    """Add the tables of one recording to the dataset, unless its entry says that they are there.

    `run`: the name of the run, by which its unfinished files are known. `redo`: whatever its entry
    says.
    """
    if file.bad is not None:
        return FileOutcome(file, bad=file.bad)
    if file.bytes > LARGEST:
        return FileOutcome(file, bad=_TOO_LARGE)
    try:
        return _work(file, dataset, settings, run, redo=redo)
    except CaptureError as error:
        return FileOutcome(file, bad=error.problem)
    except FleetError as error:
        return FileOutcome(
            file, bad=error.problem, ends=error.place != shown(file.url) and not is_of_file(error)
        )
    except MikasError as error:
        return FileOutcome(file, bad=error.reason)
    except UnfitFile as error:
        return FileOutcome(file, bad=error.text)
    except Exception as error:  # one file must not end the work on all others
        if (refusal := refusal_of(error)) is not None:
            return FileOutcome(file, bad=refusal, ends=refused_number(error) in OF_PLACE)
        if isinstance(error, OSError):
            return FileOutcome(file, bad=reason_of(error))
        kind = without_secrets(f"{type(error).__name__}: {error}", place=f"{file.url}::{dataset}")
        return FileOutcome(file, bad=_BUG.filled(kind=kind[:300]))


def _work(
    file: FoundFile, dataset: str, settings: InterpretingSettings, run: str, *, redo: bool
) -> FileOutcome:
    from mikas.fleet.interpreting import interpret

    target = store(dataset)
    if target.read(MARKER, LONGEST) is None:
        raise FleetError(shown(dataset), _NOT_SEEN)
    with as_local(file.url) as path:
        CaptureReader(path)  # raises, if it is no capture
        digest, size, opening = digest_of(path)
        key = digest[:32]
        if (entry := _known(target, key)) is not None:
            if entry.is_current(settings.version, settings.car) and not redo:
                return FileOutcome(file, entry)
            settings = replace(settings, car=settings.car or entry.given)
        name = PurePath(shown(file.url)).name
        with target.workshop(run) as folder:
            made = interpret(path, name, key, settings, folder)
            tables = {}
            for each, part in made.files.items():
                written, length, _ = digest_of(part)
                tables[each] = stamp_of(length, written)
                target.put(each, part)
    sources = {shown(file.url): file.stamp} if file.stamp else {}
    entry = LedgerEntry(
        key, digest, size, _heads(opening), settings.version, settings.car, made.car, made.drives,
        made.rows, made.seconds, made.damaged, tuple(made.files), tables, sources,
        cars=made.cars,
    )  # fmt: skip
    return FileOutcome(file, entry, is_new=True, opening=opening)


def _known(target: Store, key: str) -> LedgerEntry | None:
    """Return the entry of a recording; None: there is none that is sound."""
    try:
        data = target.read(f"{FOLDER}/{key}{SUFFIX}", LONGEST)
    except FleetError as error:
        if is_of_file(error):
            return None
        raise
    with suppress(ValueError):
        return None if data is None else parse_entry(data, f"{key}{SUFFIX}")
    return None


def _heads(opening: bytes) -> tuple[str, ...]:
    """Return a digest of the first step, of the first two, and so on."""
    ends = range(STEP, len(opening) + 1, STEP)
    return tuple(sha256(opening[:end]).hexdigest()[:16] for end in ends)


def digest_of(path: Path) -> tuple[str, int, bytes]:
    """Return the SHA-256 of a file, its size, and its first `HEAD` bytes.

    Raises `OSError`; `UnfitFile` for a link, a pipe or a device.
    """
    digest, size, opening = sha256(), 0, b""
    for block in _blocks(path):
        if len(opening) < HEAD:
            opening = (opening + block)[:HEAD]
        digest.update(block)
        size += len(block)
    return digest.hexdigest(), size, opening


def beginnings_of(path: Path, lengths: Sequence[int]) -> set[tuple[int, str]]:
    """Return `beginnings` of a file, which is read once. Raises as `digest_of`."""
    return beginnings(_blocks(path), lengths)


def beginnings(blocks: Iterator[bytes], lengths: Sequence[int]) -> set[tuple[int, str]]:
    """Return the SHA-256 of the first bytes for each of the lengths, which ascend."""
    digest, size, found = sha256(), 0, set()
    wanted = deque(lengths)
    while wanted and (block := next(blocks, b"")):
        begin = 0
        while wanted and wanted[0] <= size + len(block):
            end = wanted[0] - size
            digest.update(block[begin:end])
            found.add((wanted.popleft(), digest.hexdigest()))
            begin = end
        digest.update(block[begin:])
        size += len(block)
    return found


def _blocks(path: Path) -> Iterator[bytes]:
    with open_regular(path, follow=True, buffering=0) as file:
        while block := file.read(_BLOCK):
            yield block
