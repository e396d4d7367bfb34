"""Text and numbers from outside, made safe once, where they are read.

Files, catalogs, units and other computers may send anything. What a reader returns has passed
through here; the raw bytes stay in their file. `public_url` and `public_port` leave out of an
address what gives access. `terminal_text` is for the one place that writes to a terminal: it
escapes the rest, also in texts that were not cleaned; `spreadsheet_text` is for tables.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from itertools import groupby
from math import isfinite
from operator import itemgetter
from typing import Any, Final, NamedTuple

# Times outside of these have no date in every time zone. Seconds since 1970.
EARLIEST: Final = 0.0
LATEST: Final = 253_402_128_000.0  # 9999-12-30, 00:00 UTC: Python 3.12 looks a day ahead

REPLACEMENT: Final = "\ufffd"
_LONGEST_INTEGER: Final = 1 << 64

# Halves of surrogate pairs, controls of both sets, marks that change the direction of the text
# beside them, separators that some programs take for a new line, and U+FFFE and U+FFFF, which XML
# has no form for.
_UNSAFE: Final = re.compile(
    "[\ud800-\udfff\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ufffe\uffff]"
)


def clean_text(text: str, limit: int | None = None) -> str:
    """Return `text` with U+FFFD for every character that a screen or a file can't take.

    Line feeds and tabs stay. `limit`: a longer text is cut to that many characters.
    """
    text = text if limit is None else text[:limit]
    return text if _is_plain(text) else _UNSAFE.sub(REPLACEMENT, text.replace("\r\n", "\n"))


def clean_line(text: str, limit: int | None = None) -> str:
    """Return `clean_text` on one line: line feeds and tabs become spaces."""
    return clean_text(text, limit).replace("\n", " ").replace("\t", " ")


def clean_json(value: object) -> Any:  # noqa: ANN401  (any JSON)
    """Return a JSON value with clean texts. Raises `ValueError` for a number of no use.

    These are numbers that are not finite, and integers of more than 64 bits.
    """
    match value:
        case str():
            return clean_text(value)
        case list():
            return [clean_json(item) for item in value]
        case Mapping():
            return {clean_text(str(key)): clean_json(item) for key, item in value.items()}
        case float() if not isfinite(value):
            raise ValueError("a number is not finite")
        case int() if abs(value) > _LONGEST_INTEGER:
            raise ValueError("an integer has more than 64 bits")
    return value


# What a spreadsheet takes for a formula, also in wide signs and behind spaces and quotation marks.
# A program with another separator begins a cell at each `;`.
_FORMULA: Final = re.compile(
    r"(?P<before>^|[;\t\r\n])(?P<text>(?:[^\S\t\r\n]|[\"'\u200b\ufeff])*[=+\-@\uff1d\uff0b\uff0d\uff20][^;\t\r\n]+)"
)
_NUMBER: Final = re.compile(r"[+-]?\d+(?:[.,]\d+)?(?:[eE][+-]?\d+)?")


def spreadsheet_text(text: str) -> str:
    """Return a text cell for a table that a spreadsheet opens: what it would take for a formula
    begins with an apostrophe. A number stays one. For each writer of CSV or cells with tabs.
    """
    return _FORMULA.sub(_as_text, text)


def _as_text(found: re.Match[str]) -> str:
    if _NUMBER.fullmatch(found["text"].strip()):
        return found[0]
    return f"{found['before']}'{found['text']}"


def is_in_calendar(time: float) -> bool:
    """Return whether `time`, in seconds since 1970, has a date in every time zone."""
    return EARLIEST <= time <= LATEST  # also false for NaN


def terminal_text(text: str) -> str:
    """Return `text` with escapes such as `\\x1b` for all that would control a terminal."""
    return text if _is_plain(text) else _UNSAFE.sub(lambda match: _escaped(match[0]), text)


def terminal_json(text: str) -> str:
    """Return a JSON text with the escapes of JSON, `\\u001b`, for the same: it stays JSON."""
    if _is_plain(text):
        return text
    return _UNSAFE.sub(lambda match: f"\\u{ord(match[0]):04x}", text)


def _is_plain(text: str) -> bool:
    """Return whether the text surely is safe, as most are; in half the time of a search."""
    return text.rstrip("\n").isprintable()


def _escaped(character: str) -> str:
    code = ord(character)
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}"


_CHAIN: Final = re.compile("::(?=[A-Za-z][A-Za-z0-9+.-]*://)")  # zip://in::s3://bucket/all.zip
_URL: Final = re.compile(r"([A-Za-z][A-Za-z0-9+.-]+:(?://)?)(.*)", re.DOTALL)
SECRET_VARIABLES: Final = (  # of the environment
    "AWS_SECRET_ACCESS_KEY", "AWS_SESSION_TOKEN", "AWS_ACCESS_KEY_ID", "MIKAS_MQTT_PASSWORD",
)  # fmt: skip
_PATHS: Final = ("file:", "local:", "replay:", "serial:")  # schemes that a path follows
_SECRET_OPTION: Final = re.compile(
    r"(?<=[?&;])([^=&;]*(?:pass|pwd|token|secret|key|sig|auth|cred)[^=&;]*)=([^&]*)", re.IGNORECASE
)
LOCAL: Final = ("file://", "local://")  # all names that fsspec has for folders of this computer
_SHORTEST: Final = 3  # bytes of a secret that are looked for in other texts
_LONG: Final = 8  # of a name; and a run of as many bytes of a longer secret is looked for, too
_QUOTED: Final = re.compile(rb"%([0-9a-f]{2})")


def public_url(url: str) -> str:
    """Return the address of a place without what gives access to it: a user's name and password,
    and all behind `?` or `#`, where a signed URL has its signature. A path stays as it is.
    """
    return "::".join(f"{it.scheme}{it.place}" for it in _chained(url))


def public_port(url: str) -> str:
    """Return a port's URL without name and password, and without the values of secret options."""
    parts = _parted(url)
    rest = _SECRET_OPTION.sub(r"\1=…", parts.place + parts.query)
    return f"{parts.scheme}{'…@' if parts.user else ''}{rest}"


def without_secrets(text: str, *, place: str = "", port: str = "") -> str:
    """Return a text about an address with `…` for each part that its public form leaves out."""
    return without(text, secrets_of(place=place, port=port))


def secrets_of(*others: str, place: str = "", port: str = "") -> frozenset[bytes]:
    """Return what `without` looks for: pieces of the secrets of two addresses, and of `others`.

    Foreign code quotes and unquotes at will, cuts texts off, and escapes odd signs in other ways.
    So, unquoted and without case, these are each run of eight bytes of a secret, each run of three
    or more ASCII letters and digits between other signs, and a shorter secret whole.
    """
    found = [*others, *_pieces(_parted(port)), *(it[1] for it in _SECRET_OPTION.findall(port))]
    for parts in _chained(place):
        query = parts.query[1:]
        found += [*_pieces(parts), query, *re.split("[&;=]", query)]
    whole = {_unquoted(it)[0] for it in found}
    pieces = whole.union(*(re.split(rb"[^a-z0-9]+", it) for it in whole))
    runs = {it[at : at + _LONG] for it in pieces for at in range(max(1, len(it) - _LONG + 1))}
    return frozenset(it for it in runs if len(it) >= _SHORTEST)


def without(text: str, secrets: frozenset[bytes]) -> str:
    """Return `text` with `…` for all that is one of `secrets_of` some address, however quoted."""
    if not secrets:
        return text
    unquoted, spans = _unquoted(text)
    hidden = bytearray(len(text))
    longest_first = b"|".join(map(re.escape, sorted(secrets, key=len, reverse=True)))
    for found in re.finditer(b"(?=(%s))" % longest_first, unquoted):  # they overlap
        start, end = spans[found.start(1)].start, spans[found.end(1) - 1].stop
        hidden[start:end] = b"\1" * (end - start)
    groups = groupby(zip(text, hidden, strict=True), key=itemgetter(1))
    return "".join("…" if secret else "".join(it[0] for it in run) for secret, run in groups)


def _unquoted(text: str) -> tuple[bytes, list[range]]:
    """Return the bytes of a text as far as it can be unquoted, in lower case and with spaces for
    `+`, and for each byte the characters that it was. All quoted forms of a text have the same.
    """
    found, spans = bytearray(), list[range]()
    for at, character in enumerate(text):
        for byte in character.encode("utf-8", "surrogatepass").lower():
            found.append(ord(" ") if byte == ord("+") else byte)
            spans.append(range(at, at + 1))
            while quoted := _QUOTED.fullmatch(found, max(0, len(found) - 3)):
                code = bytes([int(quoted[1], 16)]).lower()
                found[-3:] = b" " if code == b"+" else code
                spans[-3:] = [range(spans[-3].start, at + 1)]
    return bytes(found), spans


class _Parts(NamedTuple):
    """`user`: name and password with their `@`; `query`: with its sign, of a URL with slashes also
    a fragment. `place` is all that no other part has.
    """

    scheme: str
    user: str
    place: str
    query: str


def _chained(place: str) -> list[_Parts]:
    """Part the addresses of a chain of fsspec. A password may have `::` in it."""
    return list(map(_parted, _CHAIN.split(place)))


def _parted(url: str) -> _Parts:
    """Part an address. A password may have any sign in it, also `@` and `/`, which belong in
    percent signs: so one ends at the last `@`.
    """
    found = _URL.fullmatch(url)
    scheme, rest = found.groups() if found else ("", url)
    user = ""
    if found and not scheme.startswith(_PATHS):
        host = re.split("[/?#]", rest)[0]
        has_password = ":" in host or not scheme.endswith("//")
        has_password &= not re.match(r"\?\w+=", rest)  # options, as of sim:?scenario=…
        user = "".join((rest if has_password else host).rpartition("@")[:2])
    place = rest[len(user) :]
    end = re.search("[?#]" if scheme.endswith("//") and scheme not in LOCAL else r"(?!)", place)
    at = len(place) if end is None else end.start()
    return _Parts(scheme, user, place[:at], place[at:])


def _pieces(parts: _Parts) -> list[str]:
    user = parts.user.removesuffix("@")
    name, _, password = user.partition(":")
    passwords = [password]
    if not parts.scheme.endswith("//"):  # the name may be the scheme: me:password@host
        passwords.append(user)
    names = [name] if len(name) >= _LONG else []  # a token stands there too, others are words
    return names + passwords
