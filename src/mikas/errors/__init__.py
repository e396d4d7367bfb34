"""Everything that can go wrong, as one tree.

    MikasError
    ├── UsageError (ValueError)        the user asked wrongly; the ECU was not touched
    │   ├── UnknownParameter           no such name or code; carries the nearest names
    │   ├── AddressOutOfRange          outside the memory space
    │   ├── ValueDoesNotFit            not representable in the parameter's raw bytes
    │   ├── BadPortUrl                 the port's URL or one of its options makes no sense
    │   ├── CatalogError               a catalog file is wrong: file, line, what was expected
    │   ├── CaptureError               a capture file can't be read, or can't be written
    │   ├── ExportError                an export can't be made
    │   ├── JournalError               the journal of changes can't be written
    │   └── MissingExtra               an optional library is not installed
    ├── NoConnection (ConnectionError) nobody to talk to
    │   ├── PortNotFound               no such port, or no adapter at all
    │   │   └── NoPortGiven            none was named, and not just one is plugged in
    │   ├── PortBusy                   another program has it
    │   ├── PortDenied                 the user may not open it
    │   ├── PortFailed                 the system gave another reason
    │   ├── LinkLost                   the adapter went away while in use
    │   │   └── RecordingOver          what `replay:` played has ended
    │   ├── NoEcho                     nothing came back at all (D1)
    │   ├── EchoOnly                   the echo came back, the ECU is silent (D1)
    │   └── NotAKLineAdapter           an ELM327 answered instead of a wire
    ├── LineError                      the ECU is there, the exchange was spoilt
    │   ├── NoResponse (TimeoutError)  silence, D14
    │   │   └── EngineStopped          of a stream by strokes, as there are none (D15)
    │   ├── EchoDiffers                what came back is not what was sent (D1)
    │   ├── DamagedResponse            checksum, cut or over-long frame (§2)
    │   ├── WrongLength                a good frame, but not this request's (D13)
    │   ├── WrongAddress               a good frame that echoes another address (D13)
    │   ├── WrongContent               a good frame that makes no sense in itself (§3)
    │   ├── LineNotQuiet               bytes keep coming (D2, D12)
    │   └── SyncLost                   resynchronisation failed (D13)
    ├── EcuRefused                     the ECU said no
    │   ├── WriteRefused               it answered 01 to a write (§3)
    │   ├── NotSupported               it does not know the command (D10)
    │   └── ReadBackDiffers            it accepted a write and holds something else
    └── NotConfirmed                   a change that nobody approved

Each error carries what was sent, what came back, and when, and its message ends with what to try:
`str(error)` is that in English, `error.text` in both languages, `error.gui_text` without the
words of a terminal. Each is also the matching builtin.
"""

from mikas.errors.base import (
    MikasError,
    hex_dump,
    reason_at,
    reason_of,
)
from mikas.errors.connection import (
    EchoOnly,
    LinkLost,
    NoConnection,
    NoEcho,
    NoPortGiven,
    NotAKLineAdapter,
    PortBusy,
    PortDenied,
    PortFailed,
    PortNotFound,
    RecordingOver,
)
from mikas.errors.line import (
    DamagedResponse,
    EchoDiffers,
    EngineStopped,
    LineError,
    LineNotQuiet,
    NoResponse,
    SyncLost,
    WrongAddress,
    WrongContent,
    WrongLength,
)
from mikas.errors.refusal import (
    EcuRefused,
    NotConfirmed,
    NotSupported,
    ReadBackDiffers,
    WriteRefused,
)
from mikas.errors.usage import (
    AddressOutOfRange,
    BadPortUrl,
    CaptureError,
    CatalogError,
    ExportError,
    JournalError,
    MissingExtra,
    UnknownParameter,
    UsageError,
    ValueDoesNotFit,
)

__all__ = [
    "AddressOutOfRange",
    "BadPortUrl",
    "CaptureError",
    "CatalogError",
    "DamagedResponse",
    "EchoDiffers",
    "EchoOnly",
    "EcuRefused",
    "EngineStopped",
    "ExportError",
    "JournalError",
    "LineError",
    "LineNotQuiet",
    "LinkLost",
    "MikasError",
    "MissingExtra",
    "NoConnection",
    "NoEcho",
    "NoPortGiven",
    "NoResponse",
    "NotAKLineAdapter",
    "NotConfirmed",
    "NotSupported",
    "PortBusy",
    "PortDenied",
    "PortFailed",
    "PortNotFound",
    "ReadBackDiffers",
    "RecordingOver",
    "SyncLost",
    "UnknownParameter",
    "UsageError",
    "ValueDoesNotFit",
    "WriteRefused",
    "WrongAddress",
    "WrongContent",
    "WrongLength",
    "hex_dump",
    "reason_at",
    "reason_of",
]
