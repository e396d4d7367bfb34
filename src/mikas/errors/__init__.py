"""The tree of all errors.

    MikasError
    ├── UsageError (ValueError)        wrong use; nothing was sent to the ECU
    │   ├── UnknownParameter           no such name or code; carries the nearest names
    │   ├── NeedsSamples               a derived channel that one reading does not give
    │   ├── NoList                     the parameters of the unit's list are unknown
    │   ├── AddressOutOfRange          outside the memory space
    │   ├── ValueDoesNotFit            not representable in the parameter's raw bytes
    │   ├── BadPortUrl                 invalid port URL, or an invalid option in it
    │   ├── CatalogError               a catalog file is wrong: file, line, what was expected
    │   ├── FormulaError               a formula is wrong: which part of it
    │   ├── CaptureError               a capture file can't be read, or can't be written
    │   │   └── DiskFull (OSError)     there is no room for it
    │   ├── ExportError                an export can't be made
    │   ├── ForeignLogError            another program's log can't be read: file, line or byte
    │   ├── FleetError                 a place of recordings or a dataset can't be used
    │   ├── JournalError               the journal of changes can't be written
    │   └── MissingExtra               an optional library is not installed
    ├── NoConnection (ConnectionError) no port, no adapter or no ECU
    │   ├── PortNotFound (FileNotFoundError)   no such port, or no adapter at all
    │   │   ├── NoPortGiven            no port named, and not exactly one adapter
    │   │   ├── AnotherAdapter         its name is another adapter's now
    │   │   ├── AdapterTaken           a program has taken it from its driver
    │   │   │   └── TakenByBrltty      brltty has (braille displays)
    │   │   └── AdapterWithoutDriver   plugged in, served by no driver
    │   ├── PortBusy                   in use by another program
    │   │   └── PortProbed             in use by ModemManager
    │   ├── PortDenied (PermissionError)       no permission to open it
    │   ├── PortFailed                 not opened for another reason
    │   ├── LinkLost                   the adapter disconnected while in use
    │   │   ├── LinkClosed             the program itself has closed it
    │   │   ├── ConnectionSilent       over a network, nothing came back for seconds
    │   │   ├── OtherService           over a network, another service answers there
    │   │   ├── PortTaken              over a network, another client has it (also a PortBusy)
    │   │   ├── LineFlooded            it sends more than a line can carry
    │   │   └── RecordingOver          the recording played by `replay:` has ended
    │   ├── NoEcho (TimeoutError)      nothing received, not even the echo (D1)
    │   ├── EchoOnly (TimeoutError)    echo received, no response from the ECU (D1)
    │   ├── NotAKLineAdapter           an ELM327 instead of a plain adapter
    │   └── NoBroker                   no connection to an MQTT broker
    │       ├── BrokerNotFound         the name of its computer is unknown
    │       ├── BrokerUnreachable      nothing answers there as a broker does
    │       ├── BrokerRefused          it does not let this client in
    │       ├── BrokerNotTrusted       its certificate can't be verified
    │       └── BrokerLost             the connection broke off
    ├── LineError                      the ECU is there, the exchange failed
    │   ├── NoResponse (TimeoutError)  silence, D14
    │   │   └── EngineStopped          no response to a stream by strokes (D15)
    │   ├── AnswersLate                each response comes after the time-out (D14)
    │   ├── EchoDiffers                the echo differs from the bytes sent (D1)
    │   │   ├── WrongEchoSetting       the line echoes, and the setting says it does not, or so
    │   │   └── EchoTwice              the request came back twice, no response (D1)
    │   ├── DamagedResponse            checksum, cut or over-long frame (§2)
    │   ├── WrongLength                a valid frame of a length not requested (D13)
    │   ├── WrongAddress               a valid frame with another address (D13)
    │   ├── WrongContent               a valid frame with invalid content (§3)
    │   ├── LineNotQuiet               bytes keep coming (D2, D12)
    │   ├── ReadingSuspended           the program did not run (Ctrl-Z, a laptop asleep)
    │   └── SyncLost                   resynchronisation failed (D13)
    ├── DeadlinePassed (TimeoutError)  the timeout of a call has passed
    ├── EcuRefused                     the ECU refused
    │   ├── WriteRefused               response 01 to a write (§3)
    │   ├── NotSupported               unknown command or parameter (D10)
    │   │   └── ListLost               the unit no longer has the list that was set (§3)
    │   └── ReadBackDiffers            write accepted, another value read back
    └── NotConfirmed                   a change that was not approved

Each error carries the bytes sent and received and the time; its message ends with what to try:
`str(error)` in English, `error.text` in both languages. Advice that names a command or a screen is
added by the command line (`mikas.cli.advice`) or the dashboard (`mikas.dashboard.errors`).

Each error is also the matching builtin. What the system has refused is so by its number, whatever
the class: a `CaptureError` of a missing file is a `FileNotFoundError`, an `ExportError` in the
place of a file a `FileExistsError`, one on a full disk an `OSError`, each with `errno` and
`filename` (`MikasError.caused_by`).
"""

from mikas.errors.base import AdviceTable as AdviceTable
from mikas.errors.base import MikasError as MikasError
from mikas.errors.base import UnfitFile as UnfitFile
from mikas.errors.base import hex_dump as hex_dump
from mikas.errors.base import reason_at as reason_at
from mikas.errors.base import reason_of as reason_of
from mikas.errors.connection import AdapterTaken as AdapterTaken
from mikas.errors.connection import AdapterWithoutDriver as AdapterWithoutDriver
from mikas.errors.connection import AnotherAdapter as AnotherAdapter
from mikas.errors.connection import BrokerLost as BrokerLost
from mikas.errors.connection import BrokerNotFound as BrokerNotFound
from mikas.errors.connection import BrokerNotTrusted as BrokerNotTrusted
from mikas.errors.connection import BrokerRefused as BrokerRefused
from mikas.errors.connection import BrokerUnreachable as BrokerUnreachable
from mikas.errors.connection import ConnectionSilent as ConnectionSilent
from mikas.errors.connection import EchoOnly as EchoOnly
from mikas.errors.connection import LineFlooded as LineFlooded
from mikas.errors.connection import LinkClosed as LinkClosed
from mikas.errors.connection import LinkLost as LinkLost
from mikas.errors.connection import NoBroker as NoBroker
from mikas.errors.connection import NoConnection as NoConnection
from mikas.errors.connection import NoEcho as NoEcho
from mikas.errors.connection import NoPortGiven as NoPortGiven
from mikas.errors.connection import NotAKLineAdapter as NotAKLineAdapter
from mikas.errors.connection import OtherService as OtherService
from mikas.errors.connection import PortBusy as PortBusy
from mikas.errors.connection import PortDenied as PortDenied
from mikas.errors.connection import PortFailed as PortFailed
from mikas.errors.connection import PortNotFound as PortNotFound
from mikas.errors.connection import PortProbed as PortProbed
from mikas.errors.connection import PortTaken as PortTaken
from mikas.errors.connection import RecordingOver as RecordingOver
from mikas.errors.connection import TakenByBrltty as TakenByBrltty
from mikas.errors.exchange import AnswersLate as AnswersLate
from mikas.errors.exchange import DamagedResponse as DamagedResponse
from mikas.errors.exchange import DeadlinePassed as DeadlinePassed
from mikas.errors.exchange import EchoDiffers as EchoDiffers
from mikas.errors.exchange import EchoTwice as EchoTwice
from mikas.errors.exchange import EcuRefused as EcuRefused
from mikas.errors.exchange import EngineStopped as EngineStopped
from mikas.errors.exchange import LineError as LineError
from mikas.errors.exchange import LineNotQuiet as LineNotQuiet
from mikas.errors.exchange import ListLost as ListLost
from mikas.errors.exchange import NoResponse as NoResponse
from mikas.errors.exchange import NotConfirmed as NotConfirmed
from mikas.errors.exchange import NotSupported as NotSupported
from mikas.errors.exchange import ReadBackDiffers as ReadBackDiffers
from mikas.errors.exchange import ReadingSuspended as ReadingSuspended
from mikas.errors.exchange import SyncLost as SyncLost
from mikas.errors.exchange import WriteRefused as WriteRefused
from mikas.errors.exchange import WrongAddress as WrongAddress
from mikas.errors.exchange import WrongContent as WrongContent
from mikas.errors.exchange import WrongEchoSetting as WrongEchoSetting
from mikas.errors.exchange import WrongLength as WrongLength
from mikas.errors.os_errors import system_error as system_error
from mikas.errors.port_kinds import PortKind as PortKind
from mikas.errors.port_kinds import errors_met_on as errors_met_on
from mikas.errors.port_kinds import met_on as met_on
from mikas.errors.system import refusal_of as refusal_of
from mikas.errors.system import refused_number as refused_number
from mikas.errors.usage import AddressOutOfRange as AddressOutOfRange
from mikas.errors.usage import BadPortUrl as BadPortUrl
from mikas.errors.usage import CaptureError as CaptureError
from mikas.errors.usage import CatalogError as CatalogError
from mikas.errors.usage import DiskFull as DiskFull
from mikas.errors.usage import ExportError as ExportError
from mikas.errors.usage import FleetError as FleetError
from mikas.errors.usage import ForeignLogError as ForeignLogError
from mikas.errors.usage import FormulaError as FormulaError
from mikas.errors.usage import JournalError as JournalError
from mikas.errors.usage import MissingExtra as MissingExtra
from mikas.errors.usage import NeedsSamples as NeedsSamples
from mikas.errors.usage import NoList as NoList
from mikas.errors.usage import UnknownParameter as UnknownParameter
from mikas.errors.usage import UsageError as UsageError
from mikas.errors.usage import ValueDoesNotFit as ValueDoesNotFit
from mikas.errors.usage import library as library
from mikas.errors.usage import naming_file as naming_file
from mikas.errors.usage import unusable_file as unusable_file
from mikas.errors.usage import usage_error as usage_error
