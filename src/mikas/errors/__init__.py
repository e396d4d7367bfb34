"""The tree of all errors.

    MikasError
    ├── UsageError (ValueError)        wrong use; nothing was sent to the ECU
    │   ├── UnknownParameter           no such name or code; carries the nearest names
    │   ├── AddressOutOfRange          outside the memory space
    │   ├── ValueDoesNotFit            not representable in the parameter's raw bytes
    │   ├── BadPortUrl                 invalid port URL, or an invalid option in it
    │   ├── CatalogError               a catalog file is wrong: file, line, what was expected
    │   ├── CaptureError               a capture file can't be read, or can't be written
    │   ├── ExportError                an export can't be made
    │   ├── JournalError               the journal of changes can't be written
    │   └── MissingExtra               an optional library is not installed
    ├── NoConnection (ConnectionError) no port, no adapter or no ECU
    │   ├── PortNotFound               no such port, or no adapter at all
    │   │   └── NoPortGiven            no port named, and not exactly one adapter
    │   ├── PortBusy                   in use by another program
    │   ├── PortDenied                 no permission to open it
    │   ├── PortFailed                 not opened for another reason
    │   ├── LinkLost                   the adapter disconnected while in use
    │   │   └── RecordingOver          the recording played by `replay:` has ended
    │   ├── NoEcho                     nothing received, not even the echo (D1)
    │   ├── EchoOnly                   echo received, no response from the ECU (D1)
    │   └── NotAKLineAdapter           an ELM327 instead of a plain adapter
    ├── LineError                      the ECU is there, the exchange failed
    │   ├── NoResponse (TimeoutError)  silence, D14
    │   │   └── EngineStopped          no response to a stream by strokes (D15)
    │   ├── EchoDiffers                the echo differs from the bytes sent (D1)
    │   ├── DamagedResponse            checksum, cut or over-long frame (§2)
    │   ├── WrongLength                a valid frame of a length not requested (D13)
    │   ├── WrongAddress               a valid frame with another address (D13)
    │   ├── WrongContent               a valid frame with invalid content (§3)
    │   ├── LineNotQuiet               bytes keep coming (D2, D12)
    │   └── SyncLost                   resynchronisation failed (D13)
    ├── EcuRefused                     the ECU refused
    │   ├── WriteRefused               response 01 to a write (§3)
    │   ├── NotSupported               unknown command or parameter (D10)
    │   └── ReadBackDiffers            write accepted, another value read back
    └── NotConfirmed                   a change that was not approved

Each error carries the bytes sent and received and the time; its message ends with what to try:
`str(error)` in English, `error.text` in both languages. Advice that names a command or a screen is
added by the command line (`mikas.cli.advice`) or the dashboard (`mikas.dashboard.errors`). Each
error is also the matching builtin.
"""

from mikas.errors.base import AdviceTable, MikasError, hex_dump, reason_at, reason_of
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
from mikas.errors.exchange import (
    DamagedResponse,
    EchoDiffers,
    EcuRefused,
    EngineStopped,
    LineError,
    LineNotQuiet,
    NoResponse,
    NotConfirmed,
    NotSupported,
    ReadBackDiffers,
    SyncLost,
    WriteRefused,
    WrongAddress,
    WrongContent,
    WrongLength,
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
    usage_error,
)

__all__ = [
    "AddressOutOfRange",
    "AdviceTable",
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
    "usage_error",
]
