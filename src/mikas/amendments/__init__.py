"""What the survey of a real unit would change in the catalog, and the patch that changes it.

    amendments(survey, shipped()) ──► Amendment("D11", shows, …), Amendment("RCOK", differs, …)
    patch(amendments, unit)       ──► a unified diff of the TOML files, for `git apply`

One unit proves nothing of the next: a person reads the amendments and decides.
"""

from mikas.amendments.amendment import Amendment as Amendment
from mikas.amendments.amendment import CatalogChange as CatalogChange
from mikas.amendments.patch import patch as patch
from mikas.amendments.proposing import Proposal as Proposal
from mikas.amendments.proposing import propose as propose

__all__ = ["Amendment", "CatalogChange", "Proposal", "patch", "propose"]
