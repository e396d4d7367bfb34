"""The text for a link's description: a product's name is the same in every language, a virtual
unit's is not. Links and recordings keep the description as one string, in English.
"""

from __future__ import annotations

from mikas.i18n import Text

VIRTUAL = Text("virtual ECU", "виртуальный блок")


def described(description: str) -> Text:
    """A link's or a recording's `description` for a person."""
    return VIRTUAL if description == VIRTUAL.en else Text(description, description)
