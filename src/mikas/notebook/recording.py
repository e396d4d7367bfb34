"""A recording that shows and draws itself: `mikas.open("drive.pcapng")`.

    recording = mikas.open("drive.pcapng")
    frame = recording.to_pandas()          # or to_polars(), to_arrow(), rows()
    recording.plot("FREQ", ["INJ", "JAIR"])

As the last line of a notebook's cell it shows its car, faults, gaps and channels; `print` shows the
same as text. A notebook that is opened again shows a recording whose file may be gone: that is a
sentence there, not a traceback. matplotlib is imported on use.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal, Self

from mikas.catalog import Catalog, Interpretation, load
from mikas.cleaning import clean_line
from mikas.errors import MikasError, library, reason_of, usage_error
from mikas.i18n import Text
from mikas.instruments.definition import InstrumentDefinition
from mikas.options import check_choice
from mikas.recording import recording
from mikas.recording.table.channels import with_gaps

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from mikas.i18n import Language
    from mikas.notebook.drawing import Plot
    from mikas.notebook.overview import Overview
    from mikas.notebook.picture import Moment
    from mikas.notebook.wording import Wording
    from mikas.recording.export import Result

DialectName = Literal["plain", "excel"]
"""The form of a CSV: commas and decimal points, or for an Excel with a decimal comma."""

_FEWEST: Final = 10  # points of a line


def open(  # noqa: A001  (read as `mikas.open`)
    path: str | os.PathLike[str],
    *,
    interpretation: Interpretation = "corrected",
    catalogs: str | os.PathLike[str] | Iterable[str | os.PathLike[str]] = (),
    names: str | Iterable[str] = (),
    language: Language | None = None,
    instruments: str | InstrumentDefinition | Iterable[str | InstrumentDefinition] = (),
) -> Recording:
    """Read a recording (.pcapng) and return it as a table.

    `interpretation`: corrected, literal, alternative or family (errata). `catalogs`: your own
    files, which add to and override the shipped definitions. `names`: the wanted channels in their
    order; by default all recorded ones. `language`: `en` or `ru`, for what a notebook shows; by
    default that of MIKAS_LANG, of the config file, or of the system. `instruments`: definitions, by
    file or themselves, that decode the recorded instruments of their names again.

    Raises `CaptureError` for a file that is no capture, `UsageError` for an invalid name or
    setting. `problems` lists damage in the file.
    """
    if language not in (None, "en", "ru"):
        raise usage_error(
            f"There is no language “{language}”; there are: en, ru",
            f"Языка «{language}» нет; есть: en, ru",
        )
    files = [catalogs] if isinstance(catalogs, str | os.PathLike) else catalogs
    if isinstance(instruments, str | InstrumentDefinition):
        instruments = (instruments,)
    return Recording(
        path, load(*map(Path, files)), interpretation, names, language, instruments=instruments
    )


class Recording(recording.Recording):
    """One recording. `channels`: its columns, parameters first, then those derived from them,
    then those of instruments beside the unit.

    `absent`: the wanted channels without recorded values; their columns are empty.

    Opening reads the file once, a second for ten hours; its notes (`unit`, `events`, part of
    `about`) are read on first use. No file stays open: `close`, or `with`, frees the memory that
    the rows take. `len(recording)` is the number of rows of its tables.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        catalog: Catalog,
        interpretation: str = "corrected",
        names: Iterable[str] = (),
        language: Language | None = None,
        *,
        instruments: Iterable[str | InstrumentDefinition] = (),
    ) -> None:
        super().__init__(path, catalog, interpretation, names, instruments=instruments)
        self._language = language

    def __len__(self) -> int:
        return self._extent[0]

    @property
    def duration(self) -> float:
        """The seconds from the earliest row to the latest; 0 without rows."""
        return self._extent[1]

    @cached_property
    def _extent(self) -> tuple[int, float]:
        count, times = 0, []
        for rows in with_gaps(self.rows(), self.events):
            count += len(rows.times)
            times += [float(rows.times[0]), float(rows.times[-1])]
        return count, max(times) - min(times) if times else 0.0

    def close(self) -> None:
        """Free the memory that the rows take; reading them later is a `UsageError`."""
        self.raw.close()
        self.__dict__.pop("_windows", None)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def language(self) -> Language:
        """The language of what it shows."""
        from mikas.preferences import user_language

        return self._language or user_language()

    @cached_property
    def overview(self) -> Overview:
        """What it shows of itself: car, faults, gaps, markers, each channel's range and rate.

        Raises `CaptureError` if the file can't be read any more.
        """
        from mikas.notebook.overview import overview_of

        return overview_of(self)

    def __str__(self) -> str:
        from mikas.notebook.text import text_of

        return self._shown(text_of, "{}\n  {}".format)

    def _repr_html_(self) -> str:
        """Return the same for a notebook."""
        from mikas.notebook.html import html_of, html_of_error

        return self._shown(html_of, lambda name, why: html_of_error(name, why, self.language))

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:  # noqa: ANN401, ARG002  (IPython's)
        """Show the same on IPython's console."""
        printer.text(str(self))

    def _shown(
        self, layout_of: Callable[[Wording], str], layout_of_error: Callable[[str, str], str]
    ) -> str:
        """Return what it shows of itself, or why not. Raises nothing, whatever its file holds."""
        from mikas.notebook.wording import worded

        try:
            return layout_of(worded(self, self.overview, self.language))
        except (MikasError, OSError) as error:
            text = error.text if isinstance(error, MikasError) else reason_of(error)
            return layout_of_error(clean_line(self.path.name), clean_line(text.to(self.language)))

    def export(
        self,
        out: str | os.PathLike[str],
        *,
        format: str | None = None,  # noqa: A002  (as the command's option)
        dialect: DialectName = "plain",
        overwrite: bool = False,
    ) -> Result:
        """Write it to `out` for another program, as `mikas export` does; return what was written.

        `format`: csv, mf4, parquet, msl, mlg, or one that another distribution brings; by default
        that of `out`'s suffix. `dialect`: of a CSV, excel has decimal commas. Raises `ExportError`
        (unknown format, the file exists and `overwrite` is false), `MissingExtra`.
        """
        from mikas.recording.export import DIALECTS, export

        check_choice("dialect", dialect, DIALECTS)
        return export(
            Path(out),
            self.channels,
            self.rows(),
            events=self.events,
            about=self.about,
            language=self.language,
            dialect=DIALECTS[dialect],
            overwrite=overwrite,
            format_name=format,
        )

    def plot(
        self,
        *panes: str | Sequence[str],
        start: Moment | None = None,
        end: Moment | None = None,
        by_unit: bool = False,
        stacked: bool = False,
        reference: bool = False,
        points: int = 2000,
        figsize: tuple[float, float] | None = None,
        ax: Axes | None = None,
    ) -> Plot:
        """Draw channels over time with matplotlib, as the dashboard's chart; return the drawing.

        `panes`: from top to bottom, each a channel or a list of channels; the chart's own by
        default. `start`, `end`: seconds from the first row, as tables count, or a `datetime`.
        `by_unit`: the named channels, or all, in a pane for each unit. `stacked`: each channel in a
        lane of its own. `reference`: the catalog's range at warm idle behind each line. `points`:
        of a line at most; its extremes are kept. `ax`: draw one pane there.

        The result's `figure` and its `axes` by channel are matplotlib's, to go on with; their time
        is in seconds from the first row. Raises `MissingExtra` without matplotlib, `UsageError` for
        an unknown channel or if there is nothing to draw.
        """
        library("matplotlib", feature=Text("A plot", "График"), extra="plot")
        from mikas.notebook.drawing import draw
        from mikas.notebook.panes import chosen_panes, coloured
        from mikas.notebook.picture import picture_of

        if points < _FEWEST:
            raise usage_error(
                f"points is at least {_FEWEST}", f"points не может быть меньше {_FEWEST}"
            )
        chosen = chosen_panes(self, panes, group_by_unit=by_unit)
        if ax is not None:
            chosen = [[channel for pane in chosen for channel in pane]]
        picture = picture_of(
            self,
            coloured(chosen),
            language=self.language,
            start=start,
            end=end,
            stacked=stacked,
            reference=reference,
            points=points,
        )
        return draw(picture, figsize, ax)
