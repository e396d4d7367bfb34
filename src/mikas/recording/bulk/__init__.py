"""Whole captures to columns, with numpy: the same as frame by frame, many times faster.

`frames` finds and checks frames (§2), `capture` walks the file, `match` tells which response
answers which request (D1, D13), `columns` makes values of them (§4), `reader` has it all together.

Importing this package without numpy raises `MissingExtra`; nothing else in mikas imports it before
it is used.
"""

from __future__ import annotations

from mikas.errors import MissingExtra
from mikas.i18n import Text

try:
    import numpy as np  # noqa: F401  (only whether it is there)
except ImportError as error:
    raise MissingExtra(
        feature=Text("Reading a recording as a table", "Чтение записи как таблицы"), extra="numpy"
    ) from error

from mikas.recording.bulk.frames import BulkDecoder, FrameBlock
from mikas.recording.bulk.reader import TableReader, read_table

__all__ = ["BulkDecoder", "FrameBlock", "TableReader", "read_table"]
