"""What can't be kept is said once for each kind of thing and run of the program; work goes on.

A store that can't write loses nothing now: a person misses it in the next session. Its first
failure says so, with the place, the system's reason and the consequence.

    with unkept.saying_once(_KIND, folder):   a store, around its write
    with unkept.said_to(show):                the command line, around a command
    unkept.sentences()                        the dashboard, for its page

Of a program that has no place for it (`said_to`) it is in the log of `mikas`, as a warning.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from mikas.errors import MikasError, UsageError, reason_of
from mikas.i18n import Text

_lock = threading.Lock()
_found: dict[Text, Text] = {}


@contextmanager
def saying_once(sentence: Text, place: Path) -> Iterator[None]:
    """Go on after an error, which is said as by `say_once`."""
    try:
        yield
    except (OSError, MikasError) as error:
        say_once(sentence, place, error)


def say_once(sentence: Text, place: Path, error: OSError | MikasError) -> None:
    """Say `sentence` with its fields `place` and `why` filled in, unless it was said before."""
    filled = sentence.filled(place=place, why=_reason(error))
    with _lock:
        is_first = _found.setdefault(sentence, filled) is filled
    if is_first:
        _says[-1](filled)


def sentences() -> list[Text]:
    """Return what was said in this run."""
    with _lock:
        return list(_found.values())


@contextmanager
def said_to(say: Callable[[Text], object]) -> Iterator[None]:
    """Begin a run, and give `say` all that is said in it, by any thread."""
    _says.append(say)
    _found.clear()
    try:
        yield
    finally:
        _says.remove(say)
        _found.clear()


def _warn(sentence: Text) -> None:
    from logging import NullHandler, getLogger

    logger = getLogger("mikas")
    if not logger.handlers:
        logger.addHandler(NullHandler())
    logger.warning("%s", sentence.en)


_says: list[Callable[[Text], object]] = [_warn]


def _reason(error: OSError | MikasError) -> Text:
    if isinstance(error, UsageError) and isinstance(error.__cause__, OSError):
        return reason_of(error.__cause__)  # without the file: the sentence has the place
    return error.reason if isinstance(error, MikasError) else reason_of(error)
