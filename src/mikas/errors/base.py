"""The root of the tree, and how an error tells what was on the wire."""

from __future__ import annotations

import errno
from pathlib import Path
from typing import ClassVar

from mikas.i18n import Language, Text


class MikasError(Exception):
    """The root. `request` and `received` are bytes as on the wire, `time` is the link's clock.

    `what` says what failed; `advice` gives the likely causes in order and what to try. Both may
    hold `str.format` fields, filled from the keyword arguments. `advice_on_screen` is the advice in
    the dashboard, where there is no terminal to run a command in; None: the same words do.
    """

    what: ClassVar[Text] = Text("Something failed", "Что-то не получилось")
    advice: Text = Text("", "")
    advice_on_screen: ClassVar[Text | None] = None

    def __init_subclass__(cls) -> None:
        if "advice" in cls.__dict__ and "advice_on_screen" not in cls.__dict__:
            cls.advice_on_screen = None  # what its base says there is other advice

    def __init__(
        self,
        *,
        request: bytes | None = None,
        received: bytes | None = None,
        time: float | None = None,
        advice: Text | None = None,
        on_screen: Text | None = None,
        **fields: object,
    ) -> None:
        self.request = request
        self.received = received
        self.time = time
        self.fields = fields
        self.reason = self.what.filled(**fields)
        self.advice = (advice or self.advice).filled(**fields)
        screen = on_screen or advice or self.advice_on_screen
        self._first_advice = self.advice
        self._on_screen = screen.filled(**fields) if screen else self.advice
        super().__init__(self.reason.en)

    def __str__(self) -> str:
        # Not fixed when raised: a higher layer may still add what was on the wire.
        return self.text.en

    @property
    def text(self) -> Text:
        """One short paragraph: what failed, what was sent and received (hex), what to try."""
        return Text(
            _paragraph(self.reason.en, self.advice.en, *self._wire("en")),
            _paragraph(self.reason.ru, self.advice.ru, *self._wire("ru")),
        )

    @property
    def gui_advice(self) -> Text:
        """What to try, in the dashboard's words, unless a higher layer gave other advice."""
        return self._on_screen if self.advice is self._first_advice else self.advice

    @property
    def gui_text(self) -> Text:
        """The same paragraph as `text`, for whoever looks at the dashboard."""
        return Text(
            _paragraph(self.reason.en, self.gui_advice.en, *self._wire("en")),
            _paragraph(self.reason.ru, self.gui_advice.ru, *self._wire("ru")),
        )

    def _wire(self, language: Language) -> list[str]:
        sent, received, nothing, unit = _WIRE[language]
        parts = []
        if self.request is not None:
            parts.append(f"{sent} {hex_dump(self.request, unit)}")
        if self.received is not None:
            came = f"{received} {hex_dump(self.received, unit)}"
            parts.append(came if self.received else nothing)
        return parts


_WIRE: dict[Language, tuple[str, str, str, str]] = {
    "en": ("sent", "received", "received nothing", "bytes"),
    "ru": ("послано", "принято", "не принято ничего", "байт"),
}
_LONGEST = 48


def hex_dump(data: bytes, unit: str = "bytes") -> str:
    """`01 FF 0D`, cut only when it would fill the screen."""
    if len(data) <= _LONGEST:
        return data.hex(" ").upper()
    return f"{data[:_LONGEST].hex(' ').upper()} … ({len(data)} {unit})"


def _paragraph(reason: str, advice: str, *wire: str) -> str:
    end = "" if reason.endswith((".", "?")) else "."
    text = f"{reason} ({', '.join(wire)})." if wire else f"{reason}{end}"
    return f"{text} {advice}".strip()


_IN_RUSSIAN = {
    errno.ENOENT: "нет такого файла или папки",
    errno.EACCES: "система не разрешает",
    errno.EPERM: "система не разрешает",
    errno.EROFS: "запись туда невозможна",
    errno.EISDIR: "это папка",
    errno.ENOTDIR: "часть пути — не папка",
    errno.EEXIST: "уже существует",
    errno.ENOSPC: "диск заполнен",
    errno.EADDRINUSE: "этот адрес уже занят",
    errno.EADDRNOTAVAIL: "у этой машины нет такого адреса",
}


def reason_of(error: OSError) -> Text:
    """Why the system refused, in its own words; in Russian where they are known."""
    words = error.strerror or str(error)
    return Text(words, _IN_RUSSIAN.get(error.errno or 0, words))


def reason_at(file: Path, error: OSError) -> Text:
    """The same, with the file that it is about."""
    why = reason_of(error)
    return Text(f"{file}: {why.en}", f"{file}: {why.ru}")
