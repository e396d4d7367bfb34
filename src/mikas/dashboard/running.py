"""Which dashboard of this user runs: a second click on the icon opens its page.

A running one is in `dashboard.json` in the folder of the state: its port, and a mark that is new at
each start. A file that a killed program has left names a port that is silent, or that is another
program's by now: so the port is asked for its mark.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final, Self

from mikas.files import read_json
from mikas.saving import save

_FILE: Final = "dashboard.json"
_LOCK: Final = "dashboard.lock"
_MOST: Final = 1000  # bytes
_PATIENCE: Final = 20.0  # s for a busy program to respond
_MOST_RESPONSE: Final = 1 << 20
_PORTS: Final = range(1, 1 << 16)


@dataclass(frozen=True, slots=True)
class RunningDashboard:
    """`instance`: the mark of that run, as `/api/about` gives it."""

    port: int
    instance: str

    @property
    def url(self) -> str:
        """The address for a browser on this computer."""
        return f"http://127.0.0.1:{self.port}/"

    @classmethod
    def find(cls, folder: Path) -> Self | None:
        """Return the one that runs; None: none does."""
        try:
            kept = read_json(folder / _FILE, _MOST)
            found = cls(int(kept["port"]), str(kept["instance"]))
        except (OSError, ValueError, TypeError, KeyError):
            return None
        return found if found.port in _PORTS and found.responds() else None

    def responds(self) -> bool:
        """Return whether this run is still behind its port."""
        from http.client import HTTPConnection, HTTPException

        asking = HTTPConnection("127.0.0.1", self.port, timeout=_PATIENCE)
        try:
            asking.request("GET", "/api/about")
            about = json.loads(asking.getresponse().read(_MOST_RESPONSE))
        except (OSError, ValueError, HTTPException):
            return False
        finally:
            asking.close()
        return isinstance(about, dict) and about.get("instance") == self.instance

    @contextmanager
    def kept(self, folder: Path) -> Iterator[None]:
        """Be the one that is found in `folder` while in the `with`.

        Where nothing can be written, it is not found, and works all the same: a second click opens
        a second one, which names the first if it needs its adapter. Nothing is lost by that, so
        nothing is said.
        """
        with suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)
            save(folder / _FILE, json.dumps(asdict(self)), private=True)
        try:
            yield
        finally:
            with suppress(OSError, ValueError):
                if read_json(folder / _FILE, _MOST) == asdict(self):
                    (folder / _FILE).unlink()


@contextmanager
def starting(folder: Path) -> Iterator[None]:
    """Wait until no other program is about to start: of two clicks, the second one finds the first.

    A program that is killed meanwhile lets the next one in. Where nothing can be written, no
    program waits, and as little is lost.
    """
    with ExitStack() as held:
        with suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)
            _lock(held.enter_context((folder / _LOCK).open("a")).fileno())
        yield


if sys.platform == "win32":

    def _lock(descriptor: int) -> None:
        import msvcrt

        msvcrt.locking(descriptor, msvcrt.LK_LOCK, 1)  # tries for ten seconds
else:

    def _lock(descriptor: int) -> None:
        import fcntl

        fcntl.flock(descriptor, fcntl.LOCK_EX)
