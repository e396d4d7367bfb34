"""A recording's own appearance: HTML, text, or words on why there is none.

A notebook that is opened again shows a recording whose file may be gone. That is a sentence there,
not a traceback.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from mikas.cleaning import clean_line
from mikas.errors import MikasError, reason_of
from mikas.recording.notebook.html import html_of, html_of_error
from mikas.recording.notebook.text import text_of
from mikas.recording.notebook.wording import worded

if TYPE_CHECKING:
    from mikas.i18n import Language
    from mikas.recording.recording import Recording


def as_html(recording: Recording, language: Language) -> str:
    """Return the recording as a notebook shows it. Raises nothing, whatever its file holds."""
    try:
        return html_of(worded(recording, recording.overview, language))
    except (MikasError, OSError) as error:
        name = clean_line(recording.path.name)
        return html_of_error(name, _words(error, language), language)


def as_text(recording: Recording, language: Language) -> str:
    """Return the recording as `print` shows it. Raises nothing, whatever its file holds."""
    try:
        return text_of(worded(recording, recording.overview, language))
    except (MikasError, OSError) as error:
        return f"{clean_line(recording.path.name)}\n  {_words(error, language)}"


def _words(error: MikasError | OSError, language: Language) -> str:
    text = error.text if isinstance(error, MikasError) else reason_of(error)
    return clean_line(text.to(language))
