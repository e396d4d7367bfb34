"""schemathesis against the description of the API: whatever is sent that fits it, or nearly fits
it, the answer is one that is described, and never a bug.
"""

from __future__ import annotations

from pathlib import Path

import pytest
import schemathesis
from hypothesis import HealthCheck, Phase, given, settings
from schemathesis.checks import load_all_checks
from schemathesis.specs.openapi.checks import (
    content_type_conformance,
    response_schema_conformance,
    status_code_conformance,
)

from dashboard.rig import ME
from mikas.dashboard.app import create_app
from mikas.dashboard.dashboard import Hub
from mikas.dashboard.security.access import Access
from mikas.dashboard.settings import Settings

load_all_checks()
CHECKS = [status_code_conformance, content_type_conformance, response_schema_conformance]


def described():
    hub = Hub(Settings(Path("nowhere"), state=Path("nowhere")))
    return schemathesis.openapi.from_dict(create_app(hub, Access(1)).openapi())


OPERATIONS = {it.ok().label: it.ok() for it in described().get_all_operations()}


@pytest.mark.parametrize("operation", OPERATIONS.values(), ids=OPERATIONS.keys())
def test_no_request_meets_a_bug(shared_idle, operation):
    @given(case=operation.as_strategy())
    @settings(
        max_examples=8,
        derandomize=True,
        deadline=None,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    def holds(case):
        answer = case.call(base_url=str(shared_idle.client.base_url), headers=ME)
        assert answer.status_code != 500, answer.text
        case.validate_response(answer, checks=CHECKS)

    holds()
