"""The changes that can be asked for, as they come in."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, Field

from mikas.dashboard.api.memory import Space

_LARGEST_WRITE = 256
Hex = Annotated[str, Field(pattern=r"^([0-9A-Fa-f]{2})+$", max_length=2 * _LARGEST_WRITE)]


class EraseFaults(BaseModel):
    """Erases the stored faults."""

    kind: Literal["erase_faults"]


class WriteParameter(BaseModel):
    """Writes a physical `value`, or the `raw` bytes, low byte first."""

    kind: Literal["write_parameter"]
    name: str = Field(max_length=40)
    value: float | None = Field(None, allow_inf_nan=False)
    raw: Hex | None = None


class WriteMemory(BaseModel):
    """Writes bytes from an address on."""

    kind: Literal["write_memory"]
    space: Space
    address: int = Field(ge=0, le=0xFFFF)
    data: Hex


class DeleteRecording(BaseModel):
    """Deletes a recording's file."""

    kind: Literal["delete_recording"]
    id: str = Field(max_length=255)


class DeleteDump(BaseModel):
    """Deletes a dump's file, and what is known of it."""

    kind: Literal["delete_dump"]
    id: str = Field(max_length=100)


ChangeRequest = Annotated[
    EraseFaults | WriteParameter | WriteMemory | DeleteRecording | DeleteDump,
    Field(discriminator="kind"),
]
