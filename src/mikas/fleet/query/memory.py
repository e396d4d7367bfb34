"""How much memory a question to a dataset may take.

duckdb counts its tables and its sorting, not a value that it computes: `repeat('x', 1000000000)`
has its gigabyte beside the limit, once for each step of the computation. So the system limits the
process as well, where it can: Linux. An allocation then fails, which both duckdb and Python report.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from mikas.errors import UsageError, usage_error

_MOST: Final = 2 << 30
_BESIDE: Final = 1 << 30  # what duckdb does not count, and the rows in Python


def memory_limit() -> int:
    """Return the bytes that duckdb may take: 2 GB, or half of a smaller computer."""
    try:
        installed = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):  # Windows has no such call
        return _MOST
    return min(_MOST, installed // 2)


@contextmanager
def bounded_memory() -> Iterator[None]:
    """Let this process take no more than a question may; the end of it is a `UsageError`."""
    try:
        with _bounded(memory_limit() + _BESIDE):
            yield
    except MemoryError as error:
        raise too_much_memory() from error


def too_much_memory() -> UsageError:
    """Return the error of a question that takes too much."""
    limit = f"{memory_limit() / (1 << 30):.2g}"
    return usage_error(
        f"SQL: the question needs more than {limit} GB of memory; ask for less at a time: fewer "
        "rows or columns, shorter texts",
        f"SQL: запросу мало {limit} ГБ памяти; запросите меньше за раз: меньше строк или столбцов, "
        "тексты короче",
    )


@contextmanager
def _bounded(more: int) -> Iterator[None]:
    used = _used()
    if used is None:
        yield
        return
    import resource

    before = resource.getrlimit(resource.RLIMIT_DATA)
    limits = [used + more, *(it for it in before if it != resource.RLIM_INFINITY)]
    resource.setrlimit(resource.RLIMIT_DATA, (min(limits), before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, before)


def _used() -> int | None:
    """Return the bytes that Linux counts by now; None elsewhere."""
    try:
        status = Path("/proc/self/status").read_text()
    except OSError:
        return None
    pages = [line.split()[1] for line in status.splitlines() if line.startswith("VmData:")]
    return int(pages[0]) << 10 if pages else None
