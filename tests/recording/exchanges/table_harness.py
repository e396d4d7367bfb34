"""The parameters of a recording as a table, in stretches of any size."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from mikas.catalog import Catalog
from mikas.recording.capture.reader import Source
from mikas.recording.table.channels import Rows
from mikas.recording.table.conversion import MOST_ROWS, Converter
from mikas.recording.table.raw_recording import RawRecording


class ParameterTable:
    """The recorded parameters, without derived channels."""

    def __init__(self, path: Path, catalog: Catalog, interpretation: str = "corrected") -> None:
        self.raw = RawRecording(path, catalog.size_of)
        self._converter = Converter(catalog, interpretation, self.raw.codes)
        self.channels = self._converter.channels

    def stretches(self, size: int = MOST_ROWS) -> Iterator[tuple[Source, Rows]]:
        """Yield the rows, each stretch with its port."""
        names = [channel.name for channel in self.channels]
        return self._converter.stretches(self.raw.stretches(), names, size=size)

    def rows(self, size: int = MOST_ROWS) -> Iterator[Rows]:
        """Yield the rows."""
        return (rows for _, rows in self.stretches(size))
