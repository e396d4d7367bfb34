"""Recordings from strangers, before every reader: `python -m fuzz recordings`.

`cases` makes the files from a seed, `readers` reads them, `limits` counts the work and the memory
of each reading, `campaign` runs case after case in a process that may die, `minimizing` makes a
finding small.

Not guided by coverage: a reader of a whole file takes milliseconds, so the search is led by
knowledge of the format. Case N of seed S is the same file on every machine, whatever ran before.
"""

from __future__ import annotations

from fuzz.recordings.readers import check

__all__ = ["check"]
