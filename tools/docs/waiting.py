"""Pages that wait for their text. Both lists are empty in a release."""

from __future__ import annotations

UNTRANSLATED: frozenset[str] = frozenset()
"""Shown in English on the Russian site, with a note."""

AWAITED: frozenset[str] = frozenset()
"""In the navigation already; no page yet."""
