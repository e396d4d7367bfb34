"""Pages that wait for their text. Both lists are empty in a release."""

from __future__ import annotations

UNTRANSLATED: frozenset[str] = frozenset(
    {
        "development/architecture.md",
        "development/benchmarks.md",
        "development/cable.md",
        "development/docs.md",
        "development/site.md",
        "development/soak.md",
        "development/where-do-i.md",
        "how-to/wiring.md",
        "protocol.md",
        "reference/api.md",
        "reference/capture.md",
        "reference/catalog.md",
        "reference/cli.md",
        "reference/exports.md",
        "reference/facts.md",
        "reference/guided-tests.md",
        "reference/report.md",
        "reference/scenarios.md",
        "reference/screens.md",
        "reference/security.md",
        "reference/simulator.md",
    }
)
"""Shown in English on the Russian site, with a note."""

AWAITED: frozenset[str] = frozenset(
    {
        "how-to/install.md",
        "how-to/wireshark.md",
        "how-to/sigrok.md",
        "how-to/notebooks.md",
        "how-to/fleet.md",
        "how-to/mqtt.md",
    }
)
"""In the navigation already; no page yet."""
