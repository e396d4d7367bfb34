"""`mikas watch --price`: the time that parameters take on the line, with each method."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from mikas.cli.language import decimal, tr
from mikas.sampling.plan import Plan, PlannedParameter, select

if TYPE_CHECKING:
    from mikas.catalog import Catalog, Parameter
    from mikas.cli.context import CommandContext
    from mikas.client.parameters.polling import FixedMethod

_METHODS: tuple[FixedMethod, ...] = ("single", "batch", "list", "stream")


def show_line_load(context: CommandContext, names: Sequence[str]) -> None:
    """Print the line load of each method, and of one more parameter of one byte.

    Computed from §5's figures: 960 bytes a second, 2 ms from a request to its response. The rates
    of the unit and the adapter in use are measured when `auto` chooses, and shown with `-v`.
    """
    catalog = context.options.catalog
    plan = Plan(select(catalog, names).parameters)
    more = _another(catalog, plan)
    prices = [_price(plan.with_method(method), more) for method in _METHODS]
    if context.output.json:
        context.output.data(
            {"names": [it.parameter.name for it in plan.parameters], "prices": prices}
        )
        return
    headers = [
        tr("method", "способ"), tr("bytes/cycle", "байт/цикл"),
        tr("requests/cycle", "запросов/цикл"), tr("ms/cycle", "мс/цикл"),
        tr("readings/s at most", "опр/с, не больше"), tr("one more: ms", "ещё один: мс"),
        tr("one more: readings/s", "ещё один: опр/с"),
    ]  # fmt: skip
    context.output.table(headers, [_row(price) for price in prices], right="123456")


def _price(plan: Plan, more: Parameter | None) -> dict[str, Any]:
    price = plan.price()
    price_json: dict[str, Any] = {
        "method": plan.method,
        "bytes": round(price.bytes, 1),
        "requests": round(price.requests, 2),
        "ms": round(price.seconds * 1000, 1),
        "sets_per_second": round(price.rate, 1),
        "one_more": None,
    }
    if more is not None:
        then = replace(plan, parameters=(*plan.parameters, PlannedParameter(more))).price()
        price_json["one_more"] = {
            "ms": round((then.seconds - price.seconds) * 1000, 1),
            "sets_per_second": round(then.rate, 1),
        }
    return price_json


def _row(price: dict[str, Any]) -> list[str]:
    more = price["one_more"] or {"ms": "–", "sets_per_second": "–"}
    cells = [price["bytes"], price["requests"], price["ms"], price["sets_per_second"]]
    return [
        price["method"],
        *(decimal(str(cell)) for cell in [*cells, more["ms"], more["sets_per_second"]]),
    ]


def _another(catalog: Catalog, plan: Plan) -> Parameter | None:
    """Return a parameter of one byte that is not in the plan."""
    planned = {wanted.parameter.code for wanted in plan.parameters}
    left = (p for p in catalog.parameters if p.code not in planned and p.size == 1)
    return next(left, None)
