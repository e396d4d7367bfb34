"""The file system by which duckdb reads the tables of a dataset: those files alone, never to write.

What fails in the place (no rights, a network that does not answer, a disk's error) is kept beside:
duckdb reports it like a damaged file.
"""

from __future__ import annotations

import errno
import os
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, nullcontext
from datetime import UTC, datetime
from io import BytesIO
from pathlib import Path
from typing import Any, Final

from fsspec import AbstractFileSystem

from mikas.errors import FleetError, UnfitFile, refusal_of
from mikas.files import open_regular
from mikas.fleet.places import reason_in_store
from mikas.fleet.stores import Store, UrlStore
from mikas.i18n import Text

PROTOCOL: Final = "dataset"
NO_TABLE: Final = "no table of the dataset: "  # only SQL of the user names such a file
_OF_FILE: Final = (FileNotFoundError, IsADirectoryError, NotADirectoryError)
_OF_NAME: Final = Text("{name}: {reason}", "{name}: {reason}")
_SHORTER: Final = Text("the file has become shorter", "файл стал короче")


class _TableFile:
    """A file that is opened when it is first read: duckdb opens each several times and reads few.
    It is closed when duckdb drops it: duckdb does not close all that it opens.

    Its threads share a file, and seek and read are two calls: so each thread has its own place.
    """

    def __init__(
        self,
        name: str,
        size: int,
        opened: Callable[[str], Any],
        noted: Callable[[str], AbstractContextManager[None]],
    ) -> None:
        self._name, self._size, self._opened, self._noted = name, size, opened, noted
        self._file: Any = None
        self._alone, self._of_thread = threading.Lock(), threading.local()

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        if whence != os.SEEK_SET:
            offset += self._size if whence == os.SEEK_END else self.tell()
        self._of_thread.place = offset
        return offset

    def tell(self) -> int:
        place: int = getattr(self._of_thread, "place", 0)
        return place

    def read(self, size: int = -1) -> bytes:
        place = self.tell()
        with self._noted(self._name), self._alone:
            if self._file is None:
                self._file = self._opened(self._name)
            self._file.seek(place)
            data: bytes = self._file.read(size)
            if len(data) < self._size - place and (size < 0 or len(data) < size):
                raise UnfitFile(errno.EIO, _SHORTER)
        self._of_thread.place = place + len(data)
        return data

    def close(self) -> None:
        if self._file is not None:
            self._file.close()

    __del__ = close


class DatasetFileSystem(AbstractFileSystem):  # type: ignore[misc]  # fsspec has no types
    """The dataset as duckdb sees it, `dataset://samples/…`.

    `sizes`: the files that may be read. `failures`: of the place, each with the name of the file.
    """

    protocol = PROTOCOL
    cachable = False

    def __init__(self, files: Store, sizes: Mapping[str, int]) -> None:
        super().__init__()
        self._store, self._sizes = files, sizes
        self._one_at_a_time: AbstractContextManager[Any] = nullcontext()
        if isinstance(files, UrlStore) and not files.is_object_store:
            self._one_at_a_time = threading.Lock()  # one connection, and duckdb has many threads
        self.failures: list[tuple[str, Text]] = []

    def raise_failure(self) -> None:
        """Raise `FleetError` for the first failure, if there is one."""
        for name, reason in self.failures:
            raise FleetError(self._store.place, _OF_NAME.filled(name=name, reason=reason))

    def info(self, path: str, **_: object) -> dict[str, Any]:
        return {"name": path, "type": "file", "size": self._size(_name(path))}

    def glob(self, path: str, **_: object) -> list[str]:
        return [_name(path)]

    def modified(self, _: str) -> datetime:
        return datetime(2000, 1, 1, tzinfo=UTC)  # a file is never changed

    def open(self, path: str, mode: str = "rb", **_: object) -> _TableFile:
        if mode != "rb":
            raise PermissionError(path)
        name = _name(path)
        return _TableFile(name, self._size(name), self._opened, self._noted)

    def _opened(self, name: str) -> object:
        if not isinstance(self._store, UrlStore):
            return open_regular(Path(self._at(name)))
        if isinstance(self._one_at_a_time, nullcontext):
            return self._store.system.open(self._at(name), "rb")
        with self._one_at_a_time:
            return BytesIO(self._store.system.cat_file(self._at(name)))

    def _at(self, name: str) -> str:
        return f"{self._store.root}/{name}"  # type: ignore[attr-defined]  # of both stores

    def _size(self, name: str) -> int:
        if name not in self._sizes:
            raise FileNotFoundError(f"{NO_TABLE}{name}")
        return self._sizes[name]

    @contextmanager
    def _noted(self, name: str) -> Iterator[None]:
        try:
            yield
        except UnfitFile as error:
            reason = _OF_NAME.filled(name=name, reason=error.text)
            raise UnfitFile(errno.EIO, reason) from error
        except _OF_FILE:
            raise
        except Exception as error:
            reason = refusal_of(error) or reason_in_store(error)  # an error would keep files open
            self.failures.append((name, reason))
            raise


def _name(path: str) -> str:
    return path.removeprefix(f"{PROTOCOL}://")
