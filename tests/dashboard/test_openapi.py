"""schemathesis against the description of the API: whatever is sent that fits it, or nearly fits
it, the answer is one that is described, and never a bug.
"""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, Phase, given, settings

from dashboard.rig import ME
from mikas.dashboard.app import _PARTS, openapi_description

LABELS = [
    f"{method} {route.path}"
    for part in _PARTS
    for route in part.router.routes
    for method in getattr(route, "methods", ())
]


@pytest.fixture(scope="module")
def operations():
    """The described operations by label. They take 2 s, so they are made where they are used."""
    import schemathesis

    described = schemathesis.openapi.from_dict(openapi_description())
    return {it.ok().label: it.ok() for it in described.get_all_operations()}


@pytest.fixture(scope="module")
def checks():
    from schemathesis.checks import load_all_checks
    from schemathesis.specs.openapi import checks

    load_all_checks()
    return [
        checks.status_code_conformance,
        checks.content_type_conformance,
        checks.response_schema_conformance,
    ]


def test_every_operation_of_the_description_is_tried(operations):
    assert sorted(operations) == sorted(LABELS)


@pytest.mark.parametrize("label", LABELS)
def test_no_request_meets_a_bug(shared_idle, operations, checks, label):
    @given(case=operations[label].as_strategy())
    @settings(
        max_examples=8,
        derandomize=True,
        deadline=None,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    def holds(case):
        # As long as the rig's own client: else the library allows 10 s between two steps of a
        # diagnosis, whose commands a busy machine may try for longer.
        answer = case.call(base_url=str(shared_idle.client.base_url), headers=ME, timeout=60)
        assert answer.status_code != 500, answer.text
        case.validate_response(answer, checks=checks)

    holds()
