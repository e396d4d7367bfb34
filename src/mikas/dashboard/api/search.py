"""Routes of the search: the moments at which a condition holds, and the conditions to keep.

Live it searches the last hours that the program holds, of a recording all of it.
"""

from __future__ import annotations

from typing import Annotated, Final

from fastapi import APIRouter, Query
from pydantic import AfterValidator, BaseModel, Field

from mikas.catalog.formula_syntax import LONGEST
from mikas.catalog.lookup import is_corrected
from mikas.dashboard.api.dependencies import KnownClient, Line, TheDashboard, TheRequester
from mikas.dashboard.api.errors import errors, made_of
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.session.history import row_time
from mikas.errors import usage_error
from mikas.recording.search import SearchCondition, SearchResult, search, search_rows
from mikas.saving import KeptFile

router = APIRouter(tags=["search"])

_MOST_HITS: Final = 2000
_MOST_KEPT: Final = 50
_MOST_BYTES: Final = 1 << 20

Expression = Annotated[str, Query(max_length=LONGEST, description="FREQ > 3000 and DET")]


Time = Annotated[float, AfterValidator(row_time)]
"""The time that a row has in the API."""


class HitInfo(BaseModel):
    """A moment: the times of its first and last row; `peak` null: nothing is compared."""

    begin: Time
    end: Time
    rows: int
    peak: float | None
    peak_time: Time | None


class FoundResponse(BaseModel):
    """The first hits, and the `count` of all. `begin`, `end`: the limits of the searched time.

    `peak_of`: the formula of the peak, null: nothing is compared; `lowest`: the peak is a minimum.
    """

    hits: list[HitInfo]
    count: int
    peak_of: str | None
    lowest: bool
    begin: Time | None
    end: Time | None


class KeptSearch(BaseModel):
    """A condition that was kept."""

    name: Annotated[Line, Field(max_length=80)] = ""
    expression: Annotated[Line, Field(min_length=1, max_length=LONGEST)]


class SearchList(BaseModel):
    """The user's conditions."""

    searches: list[KeptSearch] = Field(max_length=_MOST_KEPT)


@router.get("/history/find", responses=errors())
def find_live(
    dashboard: TheDashboard,
    expression: Expression,
    seconds: Annotated[float, Query(gt=0, le=86400)] = 86400,
) -> FoundResponse:
    """Return the moments of the last `seconds` at which `expression` holds."""
    condition = SearchCondition(dashboard.catalog, expression)
    chosen = dashboard.library.interpretation
    for name in condition.requires:
        if not is_corrected(dashboard.catalog.channel(name), chosen):
            raise usage_error(
                f"{name} is sampled in the interpretation {chosen}; formulas need corrected. "
                "Search in a recording, or start the program without --interpretation",
                f"{name} опрашивается в толковании {chosen}, а формулам нужно corrected. Ищите в "
                "записи или запустите программу без --interpretation",
            )
    rows = dashboard.history.rows(seconds, condition.requires)
    return _found(condition, search_rows(rows, condition))


@router.get("/recordings/{identity}/find", responses=errors(404, 409, 504))
async def find_recorded(
    requester: TheRequester, identity: str, expression: Expression
) -> FoundResponse:
    """Return the moments of a recording at which `expression` holds."""
    library = requester.library
    condition = SearchCondition(library.catalog, expression)
    return await requester.view(
        identity, lambda file: _found(condition, search(library.opened(file), condition))
    )


@router.get("/searches", responses=errors())
def searches(dashboard: TheDashboard) -> SearchList:
    """Return the user's conditions; none if their file can't be used."""
    return search_file(dashboard).load() or SearchList(searches=[])


@router.put("/searches", responses=errors())
def write_searches(dashboard: TheDashboard, _: KnownClient, body: SearchList) -> SearchList:
    """Replace the user's conditions, all or none; each must be a formula of the catalog."""
    for kept in body.searches:
        SearchCondition(dashboard.catalog, kept.expression)
    with dashboard.saving:
        search_file(dashboard).save([kept.model_dump() for kept in body.searches])
    return searches(dashboard)


def search_file(dashboard: Dashboard) -> KeptFile[SearchList]:
    """Return the file of the user's conditions."""
    path = dashboard.settings.in_state("searches.json")
    return KeptFile(path, _MOST_BYTES, lambda stored: SearchList(searches=stored))


def _found(condition: SearchCondition, found: SearchResult) -> FoundResponse:
    return made_of(
        FoundResponse,
        found,
        hits=found.hits[:_MOST_HITS],
        count=len(found.hits),
        peak_of=condition.peak_of or None,
        lowest=condition.is_lowest,
    )
