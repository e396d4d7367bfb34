"""Routes of the actions on conditions: the rules, a trial over the last minutes, a trial of one."""

from __future__ import annotations

from math import isfinite
from typing import Annotated, Final

from fastapi import APIRouter, Path
from fastapi.responses import Response

from mikas.cancellation import check_cancelled
from mikas.catalog.lookup import is_corrected
from mikas.cleaning import public_port
from mikas.conditions import ActionRule, ConditionWatch
from mikas.conditions.loading import actions_in
from mikas.conditions.waiting import waiting_for
from mikas.dashboard.api.actions.models import (
    ActionModel,
    ActionsRequest,
    ActionsResponse,
    ActionTrial,
    model_of,
    reaches_network,
)
from mikas.dashboard.api.dependencies import (
    Controller,
    KnownClient,
    TheDashboard,
    TheRequester,
    Viewer,
)
from mikas.dashboard.api.errors import TwoTexts, errors, two
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.errors import BadRequest, NotFound, OnlyHere
from mikas.errors import CatalogError
from mikas.i18n import Text

router: Final = APIRouter(prefix="/api", tags=["actions"])

_SECONDS: Final = 600.0  # of live data in a trial
_MOST_TIMES: Final = 100
_TWICE: Final = Text("two rules have the name {name}", "два правила называются {name}")


@router.get("/actions", responses=errors())
def actions(dashboard: TheDashboard, _: Viewer) -> ActionsResponse:
    """Return the rules in use; a broker's password is shown to no client."""
    return _response(dashboard)


@router.put("/actions", responses=errors(409))
def write_actions(
    dashboard: TheDashboard, client: Controller, body: ActionsRequest
) -> ActionsResponse:
    """Replace the rules, all or none. MQTT and webhooks only from this computer."""
    names = [rule.name for rule in body.rules]
    for name in names:
        if names.count(name) > 1:
            raise BadRequest(problem=_TWICE.filled(name=name))
    before = dashboard.actions.loaded
    if body.broker and body.broker == public_port(before.broker):
        body.broker = before.broker  # with the password that was not shown
    if not client.local and reaches_network(body) != reaches_network(before):
        raise OnlyHere
    try:
        catalog, may_rest = dashboard.formula_catalog, dashboard.actions.may_rest
        loaded = actions_in(body.tables(), catalog, may_rest)
    except CatalogError as error:
        raise BadRequest(problem=error.problem) from error
    dashboard.actions.replace(loaded)
    return _response(dashboard)


@router.post("/actions/try", responses=errors(409, 504), response_model=ActionTrial)
async def try_action(requester: TheRequester, _: KnownClient, body: ActionModel) -> Response:
    """Return what a rule would have done in the last ten minutes; changes nothing."""
    return await requester.answer(lambda: _tried(requester.dashboard, body))


@router.post("/actions/{name}/perform", responses=errors(404, 409))
def perform(
    dashboard: TheDashboard, _: Controller, name: Annotated[str, Path(max_length=40)]
) -> ActionsResponse:
    """Do what a rule in use says, now, as a trial; a recording is neither started nor stopped."""
    rule = next((it for it in dashboard.actions.loaded.rules if it.name == name), None)
    if rule is None:
        raise NotFound(name=name)
    dashboard.actions.perform(rule)
    return _response(dashboard)


def _response(dashboard: Dashboard) -> ActionsResponse:
    own = dashboard.actions
    return ActionsResponse(
        rules=[model_of(rule) for rule in own.loaded.rules],
        broker=public_port(own.loaded.broker),
        topic=own.loaded.topic,
        problem=two(own.problem) if own.problem else None,
        waits={
            rule.name: two(text) for rule in own.loaded.rules if (text := _waits(dashboard, rule))
        },
        network=own.network,
        file=str(own.path),
    )


def _waits(dashboard: Dashboard, rule: ActionRule) -> Text | None:
    return waiting_for(rule.channels, dashboard.formula_catalog)


def _without_values(problem: TwoTexts | None, waits: TwoTexts | None) -> ActionTrial:
    return ActionTrial(problem=problem, waits=waits, value=None, times=[], count=0, seconds=0)


def _tried(dashboard: Dashboard, body: ActionModel) -> ActionTrial:
    table = body.table() | {"sound": True, "mqtt": False}  # what it does is no matter here
    try:
        catalog = dashboard.formula_catalog
        may_rest = dashboard.actions.may_rest
        loaded = actions_in({"action": {body.name: table}}, catalog, may_rest)
    except CatalogError as error:
        return _without_values(two(error.problem), None)
    (rule,) = loaded.rules
    waits = two(text) if (text := _waits(dashboard, rule)) else None
    if loaded.resting:
        return _without_values(None, waits)
    watch = ConditionWatch(loaded.rules, catalog)
    rows = dashboard.history.rows(_SECONDS, (*watch.requires, *watch.beside))
    later, times = dashboard.connection.later, []
    chosen = dashboard.library.interpretation
    columns = [  # formulas are in the corrected interpretation
        (name, rows.values[name])
        for name in watch.requires
        if name in rows.values and is_corrected(catalog.channel(name), chosen)
    ]
    columns += [(name, rows.values[name]) for name in watch.beside if name in rows.values]
    for at, time in enumerate(rows.times):
        if at % 256 == 0:
            check_cancelled()
        values = {name: float(column[at]) for name, column in columns}
        times += [fired.time + later for fired in watch.add(float(time), values)]
    value = watch.value(rule)
    length = float(rows.times[-1] - rows.times[0]) if len(rows.times) else 0.0
    return ActionTrial(
        problem=None,
        waits=waits,
        value=value if isfinite(value) else None,
        times=times[:_MOST_TIMES],
        count=len(times),
        seconds=length,
    )
