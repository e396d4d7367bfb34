"""An entry of a dataset's ledger, and whether one that is read is sound.

Whoever made the dataset may have written anything into it. A sound entry has the form of ours,
names tables of its own recording only, and its parts do not contradict each other. It replaces
only states of its recording, as far as both entries show (`may_replace`).
"""

from __future__ import annotations

import builtins
import json
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from datetime import date
from typing import Any, Final, TypeVar

from mikas.cleaning import clean_json
from mikas.fleet.cars import UNKNOWN, partition
from mikas.fleet.tables import TABLES
from mikas.i18n import Text

T = TypeVar("T")

FOLDER: Final = "_ledger"
SUFFIX: Final = ".json"
LONGEST: Final = 4 << 20
"""Bytes of an entry: a recording of a hundred days has some 100 KB of names of tables."""
STEP: Final = 512
HEADS: Final = 8
"""Of a recording's first bytes there is a digest for each of so many steps (`heads`)."""
LARGEST_TABLE: Final = 2 << 30
"""Bytes of a file of a table, which is smaller than its recording."""
MOST_FILES: Final = 1000  # of a recording: six tables of a hundred days
_FEWER: Final = ("sources", "replaces", "obsolete")  # of an entry that is too long

_KEY_LENGTH: Final = 32
_KEY: Final = f"[0-9a-f]{{{_KEY_LENGTH}}}"
_DATA: Final = rf"(?:{'|'.join(TABLES)})/car=[\w%-]+/day=[\w-]+/{_KEY}-[0-9a-f]{{8}}\.parquet"
_LONGEST_TEXT: Final = 1000
_NOT_SOUND: Final = Text(
    "this entry is damaged or not of mikas ({what}); its recording does not count until it is "
    "added again",
    "эта строка учёта повреждена или создана не программой mikas ({what}); её запись не "
    "считается, пока её не добавят снова",
)

NOT_ITS_OWN: Final = Text(
    "this entry is damaged or not of mikas: it replaces {name}, which is another recording; its "
    "own does not count until it is added again",
    "эта строка учёта повреждена или создана не программой mikas: она заменяет {name}, а это "
    "другая запись; её собственная не считается, пока её не добавят снова",
)


@dataclass(frozen=True, slots=True)
class LedgerEntry:
    """One recording. `heads`: digests of its beginning; `version`: of what interpreted it; `given`:
    the car given for it; `sources`: where it was found, each with its stamp then; `replaces`: its
    beginnings, which count no more, whoever writes them; `cars`: of a file with several;
    `tables`: of each file size and SHA-256, none in an entry of an earlier version.
    """

    key: str
    sha256: str
    bytes: int
    heads: tuple[str, ...]
    version: str
    given: str = ""
    car: str | None = None
    drives: int = 0
    rows: int = 0
    seconds: float = 0.0
    damaged: int = 0
    files: tuple[str, ...] = ()
    tables: dict[str, str] = field(default_factory=dict)
    sources: dict[str, str] = field(default_factory=dict)
    replaces: tuple[str, ...] = ()
    obsolete: tuple[str, ...] = ()
    cars: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """The entry's own name in the dataset."""
        return f"{FOLDER}/{self.key}.json"

    @property
    def replaced(self) -> set[str]:
        """The keys of the other recordings that it names in any way."""
        return {*self.replaces, *map(key_in, self.obsolete)} - {self.key}

    def may_replace(self, other: LedgerEntry) -> bool:
        """Return whether the other is a state of this recording, as far as the two entries show.

        Either this one goes on where the other ends, or both were found at one place.
        """
        alike = [a == b for a, b in zip(self.heads, other.heads, strict=False)]
        return self.goes_on(other) or (
            bool(alike) and all(alike) and not self.sources.keys().isdisjoint(other.sources)
        )

    def goes_on(self, other: LedgerEntry) -> bool:
        """Return whether the other may be a beginning of this recording. One without heads is none:
        it is too short to hold anything of a car.
        """
        count = len(other.heads)
        return count > 0 and self.bytes > other.bytes and self.heads[:count] == other.heads

    def is_current(self, version: str, given: str) -> bool:
        """Return whether it needs no new interpretation."""
        return self.version == version and given in ("", self.given)

    def __hash__(self) -> int:
        return hash(self.key)

    def as_json(self) -> builtins.bytes:
        """Return the entry as it is written. Of very many places and states the latest remain."""
        value = asdict(self)
        text = _written(value)
        while len(text) > LONGEST and any(value[name] for name in _FEWER):
            value["sources"] = dict(_latest_half([*value["sources"].items()]))
            for name in _FEWER[1:]:
                value[name] = _latest_half(value[name])
            text = _written(value)
        return text


def key_in(name: str) -> str:
    """Return the key of the recording that a file of a dataset belongs to."""
    return name.rpartition("/")[2][:_KEY_LENGTH]


def _written(value: Mapping[str, Any]) -> bytes:
    return json.dumps(value, ensure_ascii=False, indent=1).encode()


def _latest_half(items: Sequence[T]) -> Sequence[T]:
    return items[(len(items) + 1) // 2 :]


def json_of(data: bytes) -> Any:  # noqa: ANN401  (any JSON)
    """Return JSON from a dataset, cleaned. Raises `ValueError`, also for a name there twice."""
    try:
        return clean_json(json.loads(data, object_pairs_hook=_unique))
    except (ValueError, RecursionError):
        raise ValueError("JSON") from None


def _unique(pairs: list[tuple[str, object]]) -> dict[str, object]:
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError
    return found


def parse_entry(data: bytes, file: str) -> LedgerEntry:
    """Return the entry in `file` of the ledger. Raises `ValueError` with the wrong field."""
    value = json_of(data)
    if not isinstance(value, Mapping):
        raise ValueError("JSON")  # noqa: TRY004  (as for every other form that is wrong)
    names = LedgerEntry.__dataclass_fields__
    known = {name: value[name] for name in names if value.get(name) is not None}
    for name, is_fit in _FORMS.items():
        if not is_fit(known.get(name)):
            raise ValueError(name)
    for name in _LISTS:
        known[name] = tuple(known.get(name) or ())
    entry = LedgerEntry(**known)
    _check(entry, file)
    return entry


def _is(form: str) -> Callable[[object], bool]:
    return lambda value: isinstance(value, str) and bool(re.fullmatch(form, value))


def _is_list(form: str) -> Callable[[object], bool]:
    is_item = _is(form)
    return lambda value: value is None or (isinstance(value, list) and all(map(is_item, value)))


def _is_text(value: object) -> bool:
    return value is None or (isinstance(value, str) and len(value) <= _LONGEST_TEXT)


def _is_count(value: object) -> bool:
    return value is None or (type(value) is int and 0 <= value < 1 << 63)


def _are_sources(value: object) -> bool:
    return value is None or (
        isinstance(value, dict)
        and all(isinstance(stamp, str) and len(stamp) <= _LONGEST_TEXT for stamp in value.values())
    )


def stamp_of(size: int, sha256: str) -> str:
    """Return what `tables` has of a file."""
    return f"{size}-{sha256}"


def size_in(stamp: str) -> int:
    """Return the size that `stamp_of` has written."""
    return int(stamp.partition("-")[0])


def _are_tables(value: object) -> bool:
    is_stamp = _is(r"[0-9]{1,10}-[0-9a-f]{64}")
    return value is None or (isinstance(value, dict) and all(map(is_stamp, value.values())))


_LISTS: Final = ("heads", "files", "replaces", "obsolete", "cars")
_FORMS: Final[Mapping[str, Callable[[object], bool]]] = {
    "key": _is(_KEY),
    "sha256": _is("[0-9a-f]{64}"),
    "bytes": lambda value: value is not None and _is_count(value),
    "heads": _is_list("[0-9a-f]{16}"),
    "version": lambda value: value is not None and _is_text(value),
    "given": _is_text,
    "car": _is_text,
    **dict.fromkeys(("drives", "rows", "damaged"), _is_count),
    "seconds": lambda value: value is None or type(value) in (int, float),
    "files": _is_list(_DATA),
    "tables": _are_tables,
    "sources": _are_sources,
    "replaces": _is_list(_KEY),
    "cars": _is_list(r"(?s).{0,60}"),
    "obsolete": _is_list(rf"{_DATA}|{FOLDER}/{_KEY}\.json"),
}
"""What each part may be; None: it is not there."""


def _check(entry: LedgerEntry, file: str) -> None:
    """Raise `ValueError` for an entry whose parts contradict each other."""
    if file != f"{entry.key}{SUFFIX}" or not entry.sha256.startswith(entry.key):
        raise ValueError("key")
    if entry.key in entry.replaces or entry.name in entry.obsolete:
        raise ValueError("replaces")
    if not set(entry.files).isdisjoint(entry.obsolete):
        raise ValueError("obsolete")
    if len(entry.heads) != min(HEADS, entry.bytes // STEP):
        raise ValueError("heads")
    if len(set(entry.files)) < len(entry.files) or len(entry.files) > MOST_FILES:
        raise ValueError("files")
    if entry.tables and entry.tables.keys() != set(entry.files):
        raise ValueError("tables")
    for name in entry.files:
        _, _, of_day, file_name = name.split("/")
        day = of_day.removeprefix("day=")
        if not file_name.startswith(f"{entry.key}-") or not _is_day(day):
            raise ValueError("files")
        cars = entry.cars or (entry.car,)
        if not any(f"/{partition(car, day)}/" in name for car in cars):
            raise ValueError("car")


def _is_day(day: str) -> bool:
    try:
        return day == UNKNOWN or date.fromisoformat(day).isoformat() == day
    except ValueError:
        return False


def reason_not_sound(error: ValueError) -> Text:
    """Return in words why an entry is refused."""
    return _NOT_SOUND.filled(what=str(error)[:100])
