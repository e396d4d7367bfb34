"""The root of the tree, the display of bytes in errors, and the advice of a user interface."""

from __future__ import annotations

import errno
import os
import re
from collections.abc import Mapping, Set
from functools import cache
from pathlib import Path
from string import Formatter
from types import MappingProxyType
from typing import ClassVar, Self, TypeVar, cast

from mikas.cleaning import public_port, public_url, without_secrets
from mikas.errors.os_errors import also, builtin_named, builtin_of, describe, number_of
from mikas.errors.system import REFUSALS
from mikas.home import NO_HOME, WHY
from mikas.i18n import Language, Text

E = TypeVar("E", bound="MikasError")


class MikasError(Exception):
    """The root. `request` and `received` are bytes as on the wire, `time` is the link's clock.

    `what` names the failure; `advice` lists likely causes in order and remedies for every user.
    Both may have `str.format` fields, filled from the keyword arguments. `AdviceTable` has the
    advice of a user interface. `fields`: those of the texts and `more_fields`, and no others: a
    missing or a wrong one is a `TypeError`. An error can be copied, pickled and raised again in
    another process. Of an address in `url` (a port's) or `place` (of files) no text, no
    field and no advice has a password, nor a text about it.

    One that the system has caused is also the matching `OSError`, see `caused_by`. `number`: the
    `errno` of a class that is always one.
    """

    what: ClassVar[Text] = Text("The operation failed", "Операция не выполнена")
    """The failure in words."""
    advice: Text = Text("", "")
    """The likely causes in order, and what to try."""
    defaults: ClassVar[Mapping[str, object]] = MappingProxyType({})  # of fields that may be missing
    """The fields that may be left out."""
    more_fields: ClassVar[frozenset[str]] = frozenset()  # that no text has
    """The fields that no text has."""
    number: ClassVar[int | None] = None
    """The `errno` of a class that is always an `OSError` of one."""

    def __init__(
        self,
        *,
        request: bytes | None = None,
        received: bytes | None = None,
        time: float | None = None,
        advice: Text | None = None,
        **fields: object,
    ) -> None:
        self.request = request
        """The bytes that were sent; None: none were."""
        self.received = received
        """The bytes that came back; empty: silence."""
        self.time = time
        """The link's clock."""
        self._check_fields(fields.keys(), advice)
        fields = _public({**self.defaults, **fields})
        """The fields of this class by name."""
        self.fields: dict[str, object] = fields
        self.is_over_network = False  # of the connection to the unit
        """Whether the port is a network's."""
        self.reason: Text = self.what.filled(**fields)
        """`what` with its fields, in both languages."""
        self.advice = (advice or type(self).advice).filled(**fields)
        self._class_advice = None if advice else self.advice
        super().__init__(self.reason.en)
        if isinstance(self, OSError):
            number = number_of(self) if self.number is None else self.number
            describe(self, number, file=fields.get("url") or fields.get("file"))

    def __reduce__(self) -> tuple[object, ...]:
        state = {**self.__dict__, "args": self.args}
        if isinstance(self, OSError):
            state |= {name: getattr(self, name) for name in _OF_SYSTEM}
        if self.kind is type(self):
            return _empty, (type(self),), state
        # By its name: old pickle protocols write a builtin class as one of Python 2.
        return _empty, (self.kind, type(self).__bases__[1].__name__), state

    @property
    def kind(self) -> type[MikasError]:
        """The error's class in the tree, without a builtin one that `caused_by` has added."""
        return type(self).__bases__[0] if type(self).__dict__.get("made") else type(self)

    def caused_by(self, error: BaseException, file: str | os.PathLike[str] | None = None) -> Self:
        """Return this error as one that is also the system's `error`: `FileNotFoundError` …

        It has the `errno` and the `filename` of `error`; `file`: of the one that the user named.
        Name, texts and `args` stay as they are; an `error` that is no `OSError` changes nothing.
        """
        if not isinstance(error, OSError):
            return self
        other = _empty(cast("type[Self]", self.kind), builtin_of(error))
        other.__dict__.update(self.__dict__)
        other.args = self.args
        if isinstance(other, OSError):
            where = error.filename if file is None else os.fspath(file)
            words = error.text.en if isinstance(error, UnfitFile) else None
            describe(other, number_of(error), words, where)
        return other

    @classmethod
    def field_names(cls) -> frozenset[str]:
        """Return the names of the fields that an error of this class takes."""
        texts = _field_names(cls.what) | _field_names(cls.advice)
        return texts | cls.defaults.keys() | cls.more_fields

    def _check_fields(self, given: Set[str], advice: Text | None) -> None:
        """Raise `TypeError` for a field that is missing, or that this class does not have."""
        texts = (self.what, type(self).advice, advice or type(self).advice)
        needed = {name for text in texts for name in _field_names(text)}
        known = needed | self.field_names()
        if wrong := sorted(given - known):
            raise TypeError(
                f"{type(self).__name__} has no field {', '.join(wrong)}; it has "
                f"{', '.join(sorted(known)) or 'none'}"
            )
        if missing := sorted(needed - given - self.defaults.keys()):
            raise TypeError(f"{type(self).__name__} needs the field {', '.join(missing)}")

    def __str__(self) -> str:
        # Computed late: a higher layer may add the bytes on the wire.
        return self.text.en

    def use_class_advice(self, advice: Text) -> None:
        """Take other advice for all errors of this class."""
        self.advice = self._class_advice = advice.filled(**self.fields)

    @property
    def text(self) -> Text:
        """One short paragraph: the failure, bytes sent and received (hex), advice."""
        return self.text_with(self.advice)

    def text_with(self, advice: Text) -> Text:
        """Return the same paragraph with other advice."""
        return Text(
            _paragraph(self.reason.en, advice.en, *self._wire("en")),
            _paragraph(self.reason.ru, advice.ru, *self._wire("ru")),
        )

    @property
    def has_class_advice(self) -> bool:
        """Whether the advice is that of the class, not one given for this case."""
        return self.advice is self._class_advice

    def _wire(self, language: Language) -> list[str]:
        sent, received, nothing, unit = _WIRE[language]
        parts = []
        if self.request is not None:
            parts.append(f"{sent} {hex_dump(self.request, unit)}")
        if self.received is not None:
            parts.append(
                f"{received} {hex_dump(self.received, unit)}" if self.received else nothing
            )
        return parts


_OF_SYSTEM = ("errno", "strerror", "filename", "filename2")


def _empty(kind: type[E], builtin: type[OSError] | str | None = None) -> E:
    """Return an error that is filled next, by pickle, copy or `caused_by`."""
    if isinstance(builtin, str):
        builtin = builtin_named(builtin)
    made = kind if builtin is None else also(kind, builtin)
    new = OSError.__new__ if issubclass(made, OSError) else Exception.__new__
    return new(made)


@cache
def _field_names(text: Text) -> frozenset[str]:
    """Return the names of the fields in a text."""
    parts = (part for each in text for part in Formatter().parse(each))
    return frozenset(re.split(r"[.\[]", name)[0] for _, name, _, _ in parts if name)


def _public(fields: dict[str, object]) -> dict[str, object]:
    """Return the fields with the address in its public form, and no secret of it in another."""
    port, place = (str(fields.get(name) or "") for name in ("url", "place"))

    def public(text: str) -> str:
        return without_secrets(text, place=place, port=port)

    for name, value in fields.items():
        if isinstance(value, Text):
            fields[name] = Text(*map(public, value))
        elif isinstance(value, str):
            fields[name] = public(value)
    known = {"url": public_port(port), "place": public_url(place)}
    return fields | {name: known[name] for name in fields.keys() & known.keys()}


_WIRE: dict[Language, tuple[str, str, str, str]] = {
    "en": ("sent", "received", "received nothing", "bytes"),
    "ru": ("послано", "принято", "не принято ничего", "байт"),
}
_LONGEST = 48


def hex_dump(data: bytes, unit: str = "bytes") -> str:
    """Return `01 FF 0D`; longer data are cut."""
    if len(data) <= _LONGEST:
        return data.hex(" ").upper()
    return f"{data[:_LONGEST].hex(' ').upper()} … ({len(data)} {unit})"


def _paragraph(reason: str, advice: str, *wire: str) -> str:
    end = "" if reason.endswith((".", "?")) else "."
    text = f"{reason} ({', '.join(wire)})." if wire else f"{reason}{end}"
    return f"{text} {advice}".strip()


class AdviceTable:
    """The advice of one user interface by error class: its commands, screens, keys.

    An entry follows the class's own advice and applies to subclasses that inherit that. An error
    with individual advice (`has_class_advice` false) gets no entry. `over_network`: entries that
    take the place of others for an error of a network (`met_on`).
    """

    def __init__(
        self,
        entries: Mapping[type[MikasError], Text],
        over_network: Mapping[type[MikasError], Text] = MappingProxyType({}),
    ) -> None:
        self._entries = entries
        self._over_network = over_network

    def advice(self, error: MikasError) -> Text:
        """Return the error's advice with the entry for its class."""
        parts = self.parts(error)
        return Text(" ".join(part.en for part in parts), " ".join(part.ru for part in parts))

    def parts(self, error: MikasError) -> tuple[Text, ...]:
        """Return the advice for every user, and the entry; neither if it is empty."""
        entry = self.entry(type(error)) if error.has_class_advice else None
        if entry is not None and error.is_over_network:
            entry = self._over_network.get(type(error), entry)
        hint = () if entry is None else (entry.filled(**error.fields),)
        return tuple(part for part in (error.advice, *hint) if part.en)

    def text(self, error: MikasError) -> Text:
        """Return the error's paragraph with this advice."""
        return error.text_with(self.advice(error))

    def entry(self, kind: type[MikasError]) -> Text | None:
        """Return the entry for a class, with its fields unfilled."""
        for base in kind.__mro__:
            if base in self._entries:
                return self._entries[base]
            if "advice" in base.__dict__:
                return None
        return None


_IN_RUSSIAN = {
    errno.ENOENT: "нет такого файла или папки",
    errno.EACCES: "нет прав доступа",
    errno.EPERM: "нет прав доступа",
    errno.EISDIR: "это папка",
    errno.ENOTDIR: "часть пути — не папка",
    errno.EEXIST: "уже существует",
    errno.EADDRINUSE: "этот адрес уже занят",
    errno.EADDRNOTAVAIL: "у этого компьютера нет такого адреса",
}


class UnfitFile(OSError):
    """A file that is not opened, or not read to its end. `text`: why, in both languages."""

    def __init__(self, code: int, text: Text) -> None:
        super().__init__(code, text.en)
        self.text = text
        """Why, in both languages."""


def reason_of(error: OSError) -> Text:
    """Return the system's reason; in Russian where a translation is known."""
    if isinstance(error, UnfitFile):
        return error.text
    if str(error.filename).startswith(str(NO_HOME)):
        return WHY
    if error.errno in REFUSALS and error.errno != errno.EAGAIN:  # of a port it says other things
        return REFUSALS[error.errno]
    words = error.strerror or str(error)
    return Text(words, _IN_RUSSIAN.get(error.errno or 0, words))


def reason_at(file: Path, error: OSError) -> Text:
    """Return the system's reason with the file before it."""
    why = reason_of(error)
    return Text(f"{file}: {why.en}", f"{file}: {why.ru}")
