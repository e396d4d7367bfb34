"""The file system by which duckdb reads the tables of a dataset: those files alone, never to write.

What fails in the place (no rights, a network that does not answer, a disk's error) is kept beside:
duckdb reports it like a damaged file.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Collection, Iterator
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
_OF_FILE: Final = (UnfitFile, FileNotFoundError, IsADirectoryError, NotADirectoryError)
_FAILED: Final = Text("{name}: {reason}", "{name}: {reason}")


class _TableFile:
    """A file that is closed when duckdb drops it: duckdb does not close all that it opens.

    Its threads share a file, and seek and read are two calls: so each thread has its own place.
    """

    def __init__(self, file: Any, noted: Callable[[], AbstractContextManager[None]]) -> None:  # noqa: ANN401
        self._file, self._noted = file, noted
        self._alone, self._of_thread = threading.Lock(), threading.local()

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        if whence != os.SEEK_SET:
            with self._alone:
                size = self._file.seek(0, os.SEEK_END)
            offset += size if whence == os.SEEK_END else self.tell()
        self._of_thread.place = offset
        return offset

    def tell(self) -> int:
        place: int = getattr(self._of_thread, "place", 0)
        return place

    def read(self, size: int = -1) -> bytes:
        with self._noted(), self._alone:
            self._file.seek(self.tell())
            data: bytes = self._file.read(size)
        self._of_thread.place = self.tell() + len(data)
        return data

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401  (as the file's)
        return getattr(self._file, name)

    def __del__(self) -> None:
        self._file.close()


class DatasetFileSystem(AbstractFileSystem):  # type: ignore[misc]  # fsspec has no types
    """The dataset as duckdb sees it, `dataset://samples/…`.

    `failures`: of the place, each with the name of the file.
    """

    protocol = PROTOCOL
    cachable = False

    def __init__(self, files: Store, names: Collection[str]) -> None:
        super().__init__()
        self._store, self._names = files, names
        self._one_at_a_time: AbstractContextManager[Any] = nullcontext()
        if isinstance(files, UrlStore) and not files.is_object_store:
            self._one_at_a_time = threading.Lock()  # one connection, and duckdb has many threads
        self.failures: list[tuple[str, Text]] = []

    def raise_failure(self) -> None:
        """Raise `FleetError` for the first failure, if there is one."""
        for name, reason in self.failures:
            raise FleetError(self._store.place, _FAILED.filled(name=name, reason=reason))

    def info(self, path: str, **_: object) -> dict[str, Any]:
        at, files = self._at(path), self._store
        with self._noted(path):
            if not isinstance(files, UrlStore):
                return {"name": path, "type": "file", "size": Path(at).stat().st_size}
            with self._one_at_a_time:
                return {**files.system.info(at), "name": path}

    def glob(self, path: str, **_: object) -> list[str]:
        return [str(self._strip_protocol(path))]

    def modified(self, _: str) -> datetime:
        return datetime(2000, 1, 1, tzinfo=UTC)  # a file is never changed

    def _open(self, path: str, mode: str = "rb", **_: object) -> object:
        if mode != "rb":
            raise PermissionError(path)
        at = self._at(path)
        with self._noted(path):
            return _TableFile(self._opened(at), lambda: self._noted(path))

    def _opened(self, at: str) -> object:
        if not isinstance(self._store, UrlStore):
            return open_regular(Path(at), buffering=0)
        if isinstance(self._one_at_a_time, nullcontext):
            return self._store.system.open(at, "rb")
        with self._one_at_a_time:
            return BytesIO(self._store.system.cat_file(at))

    def _at(self, path: str) -> str:
        name = str(self._strip_protocol(path))
        if name not in self._names:
            raise FileNotFoundError(name)
        return f"{self._store.root}/{name}"  # type: ignore[attr-defined]  # of both stores

    @contextmanager
    def _noted(self, path: str) -> Iterator[None]:
        try:
            yield
        except _OF_FILE:
            raise
        except Exception as error:
            reason = refusal_of(error) or reason_in_store(error)  # an error would keep files open
            self.failures.append((str(self._strip_protocol(path)), reason))
            raise
