"""What names cost on the wire, by each method, before anything is asked: `watch --price`.

Computed from §5's figures: 960 bytes a second and 2 ms from a request to its response. What a unit
and an adapter really give is measured when `auto` chooses, and shown with `-v`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from mikas.cli.context import CommandContext
from mikas.cli.language import decimal, tr
from mikas.cli.sampling_run import SamplingOptions
from mikas.sampling.plan import Plan, PlannedParameter
from mikas.sampling.selecting import select

if TYPE_CHECKING:
    from mikas.catalog import Catalog, Parameter
    from mikas.client.polling import FixedMethod

_METHODS: tuple[FixedMethod, ...] = ("single", "batch", "list", "stream")


def tell_prices(context: CommandContext, asked: SamplingOptions) -> None:
    """A line a method, with what one more parameter of one byte would add."""
    catalog = context.catalog()
    plan = Plan(select(catalog, asked.names).parameters)
    more = _another(catalog, plan)
    prices = [_price(plan.with_method(method), more) for method in _METHODS]
    if context.output.json:
        context.output.data(
            {"names": [it.parameter.name for it in plan.parameters], "prices": prices}
        )
        return
    headers = [
        tr("method", "способ"), tr("bytes a cycle", "байт на цикл"),
        tr("requests", "запросов"), tr("ms a cycle", "мс на цикл"),
        tr("sets/s at most", "раз/с, не больше"), tr("one more, ms", "ещё один, мс"),
        tr("sets/s then", "тогда раз/с"),
    ]  # fmt: skip
    context.output.table(headers, [_row(price) for price in prices], right="123456")


def _price(plan: Plan, more: Parameter | None) -> dict[str, Any]:
    price = plan.price()
    told: dict[str, Any] = {
        "method": plan.method,
        "bytes": round(price.bytes, 1),
        "requests": round(price.requests, 2),
        "ms": round(price.seconds * 1000, 1),
        "sets_per_second": round(price.rate, 1),
        "one_more": None,
    }
    if more is not None:
        then = plan.with_parameter(PlannedParameter(more)).price()
        told["one_more"] = {
            "ms": round((then.seconds - price.seconds) * 1000, 1),
            "sets_per_second": round(then.rate, 1),
        }
    return told


def _row(price: dict[str, Any]) -> list[str]:
    more = price["one_more"] or {"ms": "–", "sets_per_second": "–"}
    cells = [price["bytes"], price["requests"], price["ms"], price["sets_per_second"]]
    return [
        price["method"],
        *(decimal(str(cell)) for cell in [*cells, more["ms"], more["sets_per_second"]]),
    ]


def _another(catalog: Catalog, plan: Plan) -> Parameter | None:
    """A parameter of one byte whose code is not asked yet."""
    asked = {wanted.parameter.code for wanted in plan.parameters}
    left = (p for p in catalog.parameters if p.code not in asked and p.size == 1)
    return next(left, None)
