"""The profile of a unit that was met: what a survey has found out of its behaviour (`unit.json`).

A `None` was not found out. A virtual unit made of the profile then follows the source's letter.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from enum import Enum
from typing import Any, Final

from mikas.catalog.loading.fields import Reader, boolean, integer
from mikas.commands import StreamAtStroke
from mikas.commands.unit import version_text
from mikas.errors import usage_error
from mikas.i18n import Text
from mikas.virtual.profiles import form
from mikas.virtual.profiles.codes import CodeProfile, Moves, code_profile
from mikas.virtual.profiles.form import WrongKey, code_text, code_texts, one_of, seconds, table_of
from mikas.virtual.quirks import BadWrite, ChecksumForm, LongList, StreamEnd

__all__ = ["CodeProfile", "Moves", "UnitProfile"]

SCHEMA: Final = 1
_LISTS: Final = {"61": "max_list_61", "64": "max_list_64", "71": "max_list_71"}
_FASTEST: Final = 4.0  # responses in a turn of the engine


@dataclass(frozen=True, slots=True)
class UnitProfile:
    """The behaviour of one unit. Times are in seconds, codes numbers; `None`: not found out."""

    version_code: int | None = None
    """The response to 01."""
    echo: bool | None = None
    """Whether the adapter returned the bytes sent (D1)."""
    turn_round: float | None = None
    """The median time from a request's last byte to the response's first (D14)."""
    turn_round_spread: float | None = None
    """How far that time lies from its median at most, strays left out."""
    inter_byte: float | None = None
    """The time between two bytes of a response beyond the wire's (D14)."""
    least_pause: float | None = None
    """The least time from a response to a request that is answered; 0: any."""
    supported: frozenset[int] = frozenset()
    """The commands that were answered (§3)."""
    missing: frozenset[int] = frozenset()
    """The commands that the unit lacks (D10)."""
    unknown: str | None = None
    """The response to an unknown command (D10): `silent`, `01`, or another body in hex."""
    bad_write: BadWrite | None = None
    """The response to a write that the unit can't do (D17)."""
    counted_blocks: bool | None = None
    """Whether 23 and 25 repeat the count (D7)."""
    max_block: int | None = None
    """The most bytes of a block that was answered (21, 23, 25)."""
    max_list_61: int | None = None
    """The most codes in one 61 (D11)."""
    max_list_64: int | None = None
    """The most codes in one 64 (D11)."""
    max_list_71: int | None = None
    """The most codes in one 71 (D11)."""
    long_list: LongList | None = None
    """The response to a longer list (D11)."""
    accepts: ChecksumForm | None = None
    """The form of a checksum `0D` or `40` that the unit understands (D3)."""
    sends: ChecksumForm | None = None
    """The form that the unit sends: stuffed or raw (D3)."""
    stream_end: StreamEnd | None = None
    """What ends a stream (D12)."""
    stream_gap: float | None = None
    """The time between two responses of a stream, the engine standing (D16)."""
    stream_load: float | None = None
    """Milliseconds more of that for each 1,000 rpm (D16)."""
    strokes: Mapping[int, float] | None = None
    """Responses in a turn of the engine, by command 7F–83 (D15)."""
    codes: Mapping[int, CodeProfile] | None = None
    """The codes that 61 answers; each other one is unknown to the unit."""
    parameter_count: int | None = None
    """The response to 60."""
    passports: tuple[str | None, ...] | None = None
    """The texts of 51–58, each `None` if not read; `None`: the owner did not consent."""
    faults: tuple[int, ...] | None = None
    """The stored faults, in the unit's order."""

    def to_json(self) -> dict[str, Any]:
        """Return the profile as the JSON values of `unit.json`."""
        out: dict[str, Any] = {"schema": SCHEMA}
        for each in fields(self):
            value = getattr(self, each.name)
            if each.name in _LISTS.values():
                out.setdefault("max_list", {})[each.name.removeprefix("max_list_")] = value
            else:
                out[each.name] = _as_json(value)
        return out | {"version_code": version_text(self.version_code)}

    @classmethod
    def from_json(cls, value: object, place: str = "unit.json") -> UnitProfile:
        """Read what `to_json` returns; a missing key is `None`.

        Raises `UsageError` for anything else, which names `place`, the key and what belongs there.
        """
        try:
            keys = form.read_keys(value, _READERS)
            if "schema" not in keys:
                raise WrongKey("schema", _SCHEMA)
            del keys["schema"]
            lists = {_LISTS[name]: most for name, most in keys.pop("max_list", {}).items()}
            profile = cls(**keys, **lists)
            if both := profile.supported & profile.missing:
                raise WrongKey("missing", _BOTH.filled(codes=", ".join(code_texts(both))))
        except WrongKey as error:
            raise error.at(place) from None
        return profile


def _as_json(value: Any) -> Any:  # noqa: ANN401  (a field of any type)
    match value:
        case frozenset():
            return code_texts(value)
        case Enum():
            return value.value
        case Mapping():
            return {
                code_text(code): each.to_json() if isinstance(each, CodeProfile) else each
                for code, each in sorted(value.items())
            }
        case tuple():
            return list(value)
    return value


_SCHEMA: Final = Text(
    f"must be {SCHEMA}: another number is that of another version of mikas",
    f"нужно {SCHEMA}: другое число — от другой версии mikas",
)
_BOTH: Final = Text(
    "has codes that stand in supported as well: {codes}",
    "здесь коды, которые есть и в supported: {codes}",
)


def _schema(value: object) -> object:
    if value == SCHEMA and isinstance(value, int) and not isinstance(value, bool):
        return value
    raise WrongKey("", _SCHEMA)


def _missing(value: object) -> frozenset[int]:
    if 0x01 in (codes := form.codes(value)):
        raise usage_error(
            "can't have 01: without it a unit can't be found",
            "не может содержать 01: без неё блок не найти",
        )
    return codes


_READERS: Final[Mapping[str, Reader]] = {
    "schema": _schema,
    "version_code": form.code,
    "echo": boolean,
    "turn_round": seconds(10),
    "turn_round_spread": seconds(10),
    "inter_byte": seconds(1),
    "least_pause": seconds(10),
    "supported": form.codes,
    "missing": _missing,
    "unknown": form.silence_or_bytes,
    "bad_write": one_of(BadWrite),
    "counted_blocks": boolean,
    "max_block": integer(1, 0xFF),
    "max_list": table_of(form.word_among(_LISTS), integer(1, 0xFF)),
    "long_list": one_of(LongList),
    "accepts": one_of(ChecksumForm),
    "sends": one_of(ChecksumForm, ChecksumForm.STUFFED, ChecksumForm.RAW),
    "stream_end": one_of(StreamEnd),
    "stream_gap": seconds(10),
    "stream_load": seconds(100),
    "strokes": table_of(form.code_among(StreamAtStroke.CODES), seconds(_FASTEST)),
    "codes": table_of(form.code, code_profile),
    "parameter_count": integer(0, 0xFF),
    "passports": form.passports,
    "faults": form.faults,
}
