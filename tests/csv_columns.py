"""An exported CSV by its columns: a test that is about one names it, wherever it stands.

`test_a_csv_file_has_these_bytes` alone says which columns there are.
"""

from __future__ import annotations

import csv


def columns_of(text: str, separator: str = ",") -> dict[str, list[str]]:
    """The cells below each title, by the title's first word."""
    titles, *rows = csv.reader(text.splitlines(), delimiter=separator, strict=True)
    return {title.split(" ")[0]: [row[at] for row in rows] for at, title in enumerate(titles)}
