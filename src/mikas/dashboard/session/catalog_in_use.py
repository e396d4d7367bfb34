"""The catalog in use, and its change while everything runs.

    a change of the user's file ──► CatalogInUse.change ──► use: sampling, history, library, changes

One change at a time; a change that was decided on a catalog which is no longer in use is refused,
so that two pages do not undo each other's. The last values of channels that are computed otherwise
now are computed again from the history.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from mikas.catalog import Catalog
from mikas.catalog.lookup import is_corrected
from mikas.catalog.own.file import OwnCatalog
from mikas.client.parameters.derived import DerivedChannels
from mikas.dashboard.errors import CatalogOutdated
from mikas.errors import CatalogError

if TYPE_CHECKING:
    from mikas.dashboard.session.history import Compute

Change = Callable[[OwnCatalog, Catalog], Catalog]


class CatalogInUse:
    """`use(catalog, before)` makes every part of the dashboard use another catalog. Any thread may
    call.
    """

    def __init__(
        self, own: OwnCatalog, catalog: Catalog, use: Callable[[Catalog, Catalog], None]
    ) -> None:
        self.own: OwnCatalog = own
        self.catalog: Catalog = catalog
        self._use = use
        self._lock = threading.Lock()

    @property
    def problem(self) -> CatalogError | None:
        """Why the own file can't be used; None: it can."""
        try:
            return self.own.load().problem
        except CatalogError as error:
            return error

    def change(self, version: str | None, make: Change) -> Catalog:
        """Change the own file by `make(own, catalog)`, and use the catalog of it.

        `version`: of the catalog on which the change was decided; None: of any. Raises
        `CatalogOutdated`, and what `make` raises; then nothing has changed.
        """
        with self._lock:
            if version is not None and version != self.catalog.version:
                raise CatalogOutdated
            catalog = make(self.own, self.catalog)
            if catalog.version != self.catalog.version:
                before, self.catalog = self.catalog, catalog
                self._use(catalog, before)
            return catalog


def changed_channels(catalog: Catalog, before: Catalog) -> list[str]:
    """Return the channels of either catalog whose values are not the same in both."""
    same = catalog.same_channels(before)
    return [name for name in {**before.channels, **catalog.channels} if name not in same]


def computing(catalog: Catalog, names: Sequence[str], interpretation: str) -> Compute | None:
    """Return the computation of the derived channels among `names` from columns of parameters.

    None: there are none, or the columns are in another interpretation than that of formulas. A
    parameter that means something else now is not among the columns.
    """
    wanted = [name for name in names if name in catalog.derived]
    gone = {name for name in names if name not in catalog.derived}
    usable = [
        name
        for name in wanted
        if gone.isdisjoint(needed := catalog.required_by([name]))
        and all(is_corrected(catalog.parameter(each), interpretation) for each in needed)
    ]
    if not usable:
        return None
    import numpy as np

    channels = DerivedChannels(catalog, usable)

    def compute(
        times: Sequence[float], columns: Mapping[str, Sequence[float]]
    ) -> dict[str, Sequence[float]]:
        values = {name: np.array(column) for name, column in columns.items()}
        made: dict[str, Any] = {**channels.columns(np.array(times), values)}
        return made

    return compute
