"""Routes of the search: the moments at which a condition holds, and the conditions to keep.

Live it searches the last hours that the program holds, of a recording all of it.
"""

from __future__ import annotations

from typing import Annotated, Final

from fastapi import APIRouter, Query
from fastapi.responses import Response
from pydantic import AfterValidator, BaseModel, Field

from mikas.catalog import Catalog
from mikas.catalog.formula_syntax import LONGEST
from mikas.catalog.formulas import POWER
from mikas.catalog.lookup import is_corrected
from mikas.dashboard.api.dependencies import (
    KnownClient,
    Line,
    TheDashboard,
    TheRequester,
    json_of,
)
from mikas.dashboard.api.errors import errors, made_of
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.library.folder import RecordingFile
from mikas.dashboard.session.history import row_time
from mikas.errors import UnknownParameter, usage_error
from mikas.i18n import Text
from mikas.recording.search import SearchCondition, SearchResult, search, search_rows
from mikas.recording.table.channels import Rows
from mikas.saving import KeptFile

router: Final = APIRouter(prefix="/api", tags=["search"])

_MOST_HITS: Final = 2000
_MOST_KEPT: Final = 50
_MOST_BYTES: Final = 1 << 20
_MOST_LIVE: Final = 5e8
"""Operations of a search: about a second. Two hours at thirty rows a second allow 2,300 for each
row."""
_MOST_RECORDED: Final = 5e9
_SHORTER_TIME: Final = Text("Or search a shorter time.", "Или ищите за меньшее время.")
_COMMAND: Final = Text(
    "The command line has no such limit: mikas find FILE EXPRESSION.",
    "В командной строке такого предела нет: mikas find ФАЙЛ УСЛОВИЕ.",
)

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


@router.get("/history/find", responses=errors(409, 504), response_model=FoundResponse)
async def find_live(
    requester: TheRequester,
    expression: Expression,
    seconds: Annotated[float, Query(gt=0, le=86400)] = 86400,
) -> Response:
    """Return the moments of the last `seconds` at which `expression` holds."""
    return await requester.answer(lambda: _find_live(requester.dashboard, expression, seconds))


def _find_live(dashboard: Dashboard, expression: str, seconds: float) -> FoundResponse:
    condition = SearchCondition(dashboard.formula_catalog, expression)
    chosen = dashboard.library.interpretation
    for name in condition.requires:
        if not is_corrected(dashboard.catalog.channel(name), chosen):
            raise usage_error(
                f"{name} is sampled in the interpretation {chosen}; formulas need corrected. "
                "Search in a recording, or start the program without --interpretation",
                f"{name} опрашивается в толковании {chosen}, а формулам нужно corrected. Ищите в "
                "записи или запустите программу без --interpretation",
            )
    rows = dashboard.history.rows(seconds, (*condition.requires, *condition.beside))
    _check_cost(condition, len(rows.times), _MOST_LIVE, _SHORTER_TIME)
    dated = Rows(rows.times + dashboard.connection.later, rows.values)
    return _found(condition, search_rows(dated, condition))


@router.get(
    "/recordings/{identity}/find", responses=errors(404, 409, 504), response_model=FoundResponse
)
async def find_recorded(requester: TheRequester, identity: str, expression: Expression) -> Response:
    """Return the moments of a recording at which `expression` holds."""
    library = requester.library

    def look(file: RecordingFile) -> Response:
        recording = library.opened(file)
        condition = SearchCondition(recording.formula_catalog, expression)
        _check_cost(condition, recording.row_count, _MOST_RECORDED, _COMMAND)
        return json_of(_found(condition, search(recording, condition)))

    return await requester.view(identity, look)


@router.get("/searches", responses=errors(409, 504), response_model=SearchList)
async def searches(requester: TheRequester) -> Response:
    """Return the user's conditions; none if their file can't be used."""
    return await requester.answer(lambda: _searches(requester.dashboard))


def _searches(dashboard: Dashboard) -> SearchList:
    return search_file(dashboard).load() or SearchList(searches=[])


@router.put("/searches", responses=errors())
def write_searches(dashboard: TheDashboard, _: KnownClient, body: SearchList) -> SearchList:
    """Replace the user's conditions, all or none; each must be a formula of the catalog.

    Those that were kept stay, also while the instrument of one is away.
    """
    before = {kept.expression for kept in _searches(dashboard).searches}
    for kept in body.searches:
        if kept.expression not in before:
            _check(dashboard.formula_catalog, kept.expression)
    with dashboard.saving:
        search_file(dashboard).save([kept.model_dump() for kept in body.searches])
    return _searches(dashboard)


def _check(catalog: Catalog, expression: str) -> None:
    """Raise `UsageError` for no condition; a recording may have a labelled instrument."""
    try:
        SearchCondition(catalog, expression)
    except UnknownParameter as error:
        if catalog.described(error.name.upper()) is None:
            raise


def search_file(dashboard: Dashboard) -> KeptFile[SearchList]:
    """Return the file of the user's conditions."""
    path = dashboard.settings.in_state("searches.json")
    return KeptFile(path, _MOST_BYTES, lambda stored: SearchList(searches=stored))


def _check_cost(condition: SearchCondition, rows: int, most: float, advice: Text) -> None:
    """Raise `UsageError` for a condition that would take too long to compute in so many rows."""
    if condition.cost * rows <= most:
        return
    allowed = max(1, int(most / rows))
    raise usage_error(
        f"The condition needs {condition.cost} operations for each of {rows} rows, and at most "
        f"{allowed} fit here. Shorten it: a power (**) counts as {POWER}, a derived channel as its "
        f"formula. {advice.en}",
        f"Условию нужно операций на каждую из {rows} строк: {condition.cost}, а можно не больше "
        f"{allowed}. Сократите его: степень (**) считается за {POWER}, производный канал — как его "
        f"формула. {advice.ru}",
    )


def _found(condition: SearchCondition, found: SearchResult) -> FoundResponse:
    return made_of(
        FoundResponse,
        found,
        hits=found.hits[:_MOST_HITS],
        count=len(found.hits),
        peak_of=condition.peak_of or None,
        lowest=condition.is_lowest,
    )
