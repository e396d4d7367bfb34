"""What a stranger may do to a dataset: case N of a seed is the same everywhere."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from random import Random
from typing import Any, Final

from fuzz.recordings import hostile
from mikas.fleet.entries import FOLDER
from mikas.fleet.ledger import MARKER

_HUGE: Final = 3 << 30  # bytes of a sparse file
_FOLDERS: Final = (FOLDER, ".parts", "drives", "faults", "samples", "statistics")
_NAMES: Final = (
    *("\x1b[2J", "a\nb", "..", "%2e%2e", "car=", "' OR 1=1 --", "*", "?", "[", "{a,b}", "\u202e"),
    *("x" * 200, "http:", "CON", "\udcff", "$(x)", "~", "é", "\x07"),
)

Change = Callable[[Random, Path, Path], None]


def change(random: Random, home: Path, canary: Path) -> list[str]:
    """Change the dataset in `home` some times; return what was done. `canary`: a file outside."""
    done = []
    for _ in range(random.choice((1, 1, 2, 3, 8))):
        name = random.choice(tuple(_CHANGES))
        done.append(name)
        _CHANGES[name](random, home, canary)
    return done


def _entry(random: Random, home: Path) -> Path | None:
    return _any_of(random, home, f"{FOLDER}/*.json")


def _any_of(random: Random, home: Path, pattern: str) -> Path | None:
    """Return a regular file that no link leads to."""
    found = sorted(it for it in home.glob(pattern) if it.is_file() and not it.is_symlink())
    small = [it for it in found if it.stat().st_size < _HUGE and it.resolve() == it.absolute()]
    return random.choice(small) if small else None


def _changed_part(random: Random, home: Path, canary: Path) -> None:
    """Give one part of an entry another value."""
    if (path := _entry(random, home)) is None:
        return
    value = _json_of(path)
    if not isinstance(value, dict) or not value:
        return
    name = random.choice(sorted(value))
    value[name] = _value(random, value[name], canary)
    path.write_text(json.dumps(value), "utf-8", "surrogatepass")


def _value(random: Random, before: object, canary: Path) -> object:
    """Return another value of the same kind, or any."""
    if random.random() < 0.3:
        return _any(random)
    if isinstance(before, bool | int | float):
        return random.choice((0, -1, 1, 10**30, 1 << 62, 1e308, float("inf"), float("nan"), True))
    if isinstance(before, str):
        return random.choice((str(canary), before[:-1], before * 2, *_NAMES))
    if isinstance(before, list):
        more = random.choice((str(canary), f"../{canary.name}", f"{FOLDER}/{canary.name}", *_NAMES))
        return random.choice(([*before, more], before * 2, before[:-1], [more] * 2000, [[]]))
    if isinstance(before, dict):
        place = random.choice((str(canary), "http://169.254.169.254/", "s3://x/y", *_NAMES))
        return random.choice((before | {place: "1-1"}, {place: "7-7"}, {}, {place: []}))
    return _any(random)


def _any(random: Random) -> Any:  # noqa: ANN401  (any JSON)
    try:
        return json.loads(hostile.value(random))
    except (ValueError, RecursionError):
        return None


def _json_of(path: Path) -> object:
    try:
        return json.loads(path.read_bytes())
    except (ValueError, RecursionError):
        return None


def _entry_as_json(random: Random, home: Path, _: Path) -> None:
    path = random.choice((_entry(random, home), home / MARKER))
    if path is not None and not path.is_symlink() and path.is_file():
        path.write_text(hostile.value(random), "utf-8", "surrogatepass")


def _entry_renamed(random: Random, home: Path, _: Path) -> None:
    if (path := _entry(random, home)) is not None:
        name = random.choice((f"{random.getrandbits(128):032x}", *_NAMES))
        _quietly(lambda: path.replace(path.with_name(f"{name.replace('/', '')}.json")))


def _entry_copied(random: Random, home: Path, _: Path) -> None:
    if (path := _entry(random, home)) is not None:
        value = _json_of(path)
        key = f"{random.getrandbits(128):032x}"
        text = json.dumps(value).replace(path.stem, key)
        path.with_name(f"{key}.json").write_text(text, "utf-8", "surrogatepass")


def _foreign_replaced(random: Random, home: Path, _: Path) -> None:
    """Add an entry that replaces other recordings, of which it knows all but their beginnings."""
    others = [it for path in sorted(home.glob(f"{FOLDER}/*.json")) if (it := _known(path))]
    key = f"{random.getrandbits(128):032x}"
    value: dict[str, object] = {"key": key, "sha256": key * 2, "version": "1", "bytes": 1 << 40}
    value["heads"] = [f"{random.getrandbits(64):016x}" for _ in range(8)]
    value["sources"] = {place: "1-1" for it in others for place in it["sources"]}
    if random.random() < 0.7:
        value["replaces"] = [it["key"] for it in others]
    if random.random() < 0.7:
        names = [name for it in others for name in (*it["files"], f"{FOLDER}/{it['key']}.json")]
        value["obsolete"] = random.sample(names, random.randint(0, len(names)))
    (home / FOLDER).mkdir(exist_ok=True)
    _quietly(lambda: (home / FOLDER / f"{key}.json").write_text(json.dumps(value), "utf-8"))


def _known(path: Path) -> dict[str, Any] | None:
    """Return an entry that has the parts of ours."""
    if not path.is_file() or path.is_symlink() or path.stat().st_size >= _HUGE:
        return None
    value = _json_of(path)
    kinds = {"key": str, "files": list, "sources": dict}
    if isinstance(value, dict) and all(isinstance(value.get(it), kinds[it]) for it in kinds):
        return value
    return None


def _bytes(random: Random, home: Path, _: Path) -> None:
    """Change some bytes of a table, or its length."""
    if (path := _any_of(random, home, "*/car=*/day=*/*")) is None:
        return
    data = bytearray(path.read_bytes())
    for _at in range(random.choice((1, 3, 30))):
        if data:  # the end of a file is its directory
            end = random.random() < 0.6
            at = random.randrange(max(0, len(data) - 600), len(data)) if end else 0
            data[at or random.randrange(len(data))] = random.randrange(256)
    kind = random.random()
    cut = bytes(data[: random.randrange(len(data) + 1)]) if kind < 0.2 else bytes(data)
    path.write_bytes(cut + random.randbytes(40) if kind > 0.9 else cut)


def _bytes_known(random: Random, home: Path, canary: Path) -> None:
    """Change a table, with entries that say nothing of its content."""
    for path in sorted(home.glob(f"{FOLDER}/*.json")):
        if path.is_file() and not path.is_symlink() and path.stat().st_size < _HUGE:
            value = _json_of(path)
            if isinstance(value, dict) and path.resolve() == path.absolute():
                path.write_text(json.dumps(value | {"tables": {}}), "utf-8", "surrogatepass")
    _bytes(random, home, canary)


def _swapped(random: Random, home: Path, _: Path) -> None:
    one, other = (_any_of(random, home, "*/car=*/day=*/*") for _ in range(2))
    if one is not None and other is not None:
        other.write_bytes(one.read_bytes())


def _missing(random: Random, home: Path, _: Path) -> None:
    if (path := _any_of(random, home, random.choice(("**/*", "*/car=*/day=*/*")))) is not None:
        path.unlink()


def _folder_gone(random: Random, home: Path, _: Path) -> None:
    path = home / random.choice(_FOLDERS)
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)


def _folder_linked(random: Random, home: Path, canary: Path) -> None:
    """Put a link to the folder of the canary in place of a folder."""
    path = home / random.choice(_FOLDERS)
    if not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
        path.symlink_to(canary.parent)


def _special(random: Random, home: Path, canary: Path) -> None:
    """Put what is no file, or a huge one, in place of a file or beside it."""
    path = _any_of(random, home, random.choice(("**/*", f"{FOLDER}/*", "*/car=*/day=*/*")))
    if path is None:
        return
    if random.random() < 0.3:
        path = path.with_name(f"0{path.name[1:]}")
    _quietly(path.unlink)
    kind = random.randrange(5)
    if os.path.lexists(path):
        return
    if kind == 0:
        os.mkfifo(path)
    elif kind == 1:
        path.symlink_to(random.choice((str(canary), "/dev/zero", "/dev/stdin", path.name)))
    elif kind == 2:
        path.mkdir()
    elif kind == 3:
        with path.open("wb") as file:
            file.truncate(_HUGE)
    else:
        path.write_bytes(random.randbytes(random.choice((0, 4, 5000))))


def _extra(random: Random, home: Path, canary: Path) -> None:
    """Add a file with a hostile name."""
    folder = home / random.choice((*_FOLDERS, "drives/car=x/day=y"))
    if folder.resolve() == canary.parent:
        return
    name = random.choice(_NAMES).replace("/", "")
    _quietly(lambda: folder.mkdir(parents=True, exist_ok=True))
    suffix = random.choice((".json", ".parquet", ""))
    _quietly(lambda: (folder / f"{name}{suffix}").write_bytes(random.randbytes(9)))


def _quietly(act: Callable[[], object]) -> None:
    with suppress(OSError):
        act()


FOREIGN: Final = "an entry that replaces others"
_CHANGES: Final[dict[str, Change]] = {
    "a part of an entry": _changed_part,
    "an entry or the marker as JSON": _entry_as_json,
    "an entry renamed": _entry_renamed,
    "an entry copied": _entry_copied,
    FOREIGN: _foreign_replaced,
    "bytes of a table": _bytes,
    "bytes of a table of an old entry": _bytes_known,
    "tables swapped": _swapped,
    "a file missing": _missing,
    "a folder missing": _folder_gone,
    "a folder linked": _folder_linked,
    "no file": _special,
    "one file more": _extra,
}
