"""Errors of pyserial and the system, translated: why a port does not open, or was lost.

A port on this computer and a connection over a network have no reason in common.

pyserial 3.5 raises one exception for everything. The reason is its `errno` on POSIX, or only the
wrapped exception (`termios.error`, a socket's), and on Windows the text of a `WinError` inside its
own text, in the system's language.
"""

from __future__ import annotations

import errno
import re
import socket
import sys
from typing import TypeVar

from serial import SerialTimeoutException

from mikas.errors import (
    NoConnection,
    PortDenied,
    PortFailed,
    PortKind,
    PortNotFound,
    met_on,
    system_error,
)
from mikas.errors.system import NEEDS_INTERFACE
from mikas.i18n import Text
from mikas.link.base import TAKES_NO_BYTES, UNPLUGGED
from mikas.link.holders import adapter_without_port, port_busy
from mikas.link.network.other_end import CLOSED_THERE, in_handshake
from mikas.link.network.rfc2217 import NO_ANSWER, NotSet
from mikas.link.network.tcp import WriteTimeout
from mikas.link.ports import find_ports, listed
from mikas.link.urls import host_and_port, kind_of, parse

SYSTEM_ERRORS: tuple[type[Exception], ...] = (OSError, ValueError)
"""Errors that pyserial raises; `ValueError`: the system or the far end refused a setting."""
if sys.platform != "win32":
    import termios

    SYSTEM_ERRORS += (termios.error,)  # not an OSError, and pyserial wraps only some of them

_ABSENT = {errno.ENOENT, errno.ENOTDIR, errno.ENODEV, errno.ENXIO}
_BUSY = {errno.EBUSY, errno.EAGAIN, errno.EWOULDBLOCK}
_DENIED = {errno.EACCES, errno.EPERM, errno.EROFS}
_NO_TTY = {errno.ENOTTY, errno.EISDIR, errno.EINVAL, errno.EOPNOTSUPP}
_UNPLUGGED = {errno.EIO, errno.ENODEV, errno.ENXIO, errno.EBADF, errno.EPIPE, errno.ECONNRESET}

# Windows gives "access denied" (5) for a COM port that is open elsewhere, and for nothing else.
_WINDOWS_ABSENT = {2, 3, 433, 1167}
_WINDOWS_BUSY = {5, 32, 170}
_WINDOWS_UNPLUGGED = {5, 6, 22, 31, 433, 995, 1167}  # depends on the driver
_WIN_ERROR = re.compile(r"\w+Error\(\d+, .*, None, (\d+)\)", re.DOTALL)

N = TypeVar("N", bound=NoConnection)

_CHECK_NAME = Text("Serial ports found: {found}.", "Найденные последовательные порты: {found}.")

_NOT_SERIAL = Text("it is not a serial port", "это не последовательный порт")
_NO_ANSWER = Text("no answer from there", "узел не отвечает")
_NO_WAY = Text("this computer has no way to it", "от этого компьютера к нему нет пути")
_OVER_NETWORK = {
    errno.ECONNREFUSED: Text("no program listens there", "на этом порту нет программы-сервера"),
    errno.ETIMEDOUT: _NO_ANSWER,
    errno.EHOSTUNREACH: _NO_ANSWER,  # also where no computer of its network has the address
    errno.EHOSTDOWN: _NO_ANSWER,
    errno.ENETUNREACH: _NO_WAY,
    errno.ENETDOWN: _NO_WAY,
    errno.EADDRNOTAVAIL: _NO_WAY,
    errno.EINVAL: NEEDS_INTERFACE,
    errno.ECONNRESET: CLOSED_THERE,
    errno.ECONNABORTED: CLOSED_THERE,
    errno.EACCES: Text("a firewall forbids it", "запрещает брандмауэр"),
    errno.EPERM: Text("a firewall forbids it", "запрещает брандмауэр"),
}


def opening_failed(url: str, error: Exception, first: bytes = b"") -> NoConnection:
    """Return the error to raise when opening `url` raised `error`.

    `first`: what the other end of a network port has said.
    """
    kind = kind_of(url)
    if kind is PortKind.NETWORK:
        if isinstance(error, NotSet):
            number = host_and_port(url)[1] if error.text is NO_ANSWER else 0
            if other := in_handshake(url, number, first, telnet=True):
                return other
        failed = PortFailed(url=url, problem=_why_not_connected(error))
        return met_on(kind, also_of_system(failed, error))
    code, windows = number_of(error), _windows_number(error)
    if code in _ABSENT or windows in _WINDOWS_ABSENT:
        return adapter_without_port(url) or PortNotFound(url=url, found=listed(find_ports()))
    if code in _BUSY or windows in _WINDOWS_BUSY:
        return port_busy(url, parse(url).address)
    if code in _DENIED:
        return PortDenied(url=url)
    is_tty = code not in _NO_TTY
    advice = None if is_tty else _CHECK_NAME.filled(found=listed(find_ports()))
    problem = _own_words(error) if is_tty else _NOT_SERIAL
    return also_of_system(PortFailed(url=url, problem=problem, advice=advice), error)


def also_of_system(failed: N, error: Exception) -> N:
    """Return the error with the system's number, and of its builtin class."""
    number = number_of(error)
    return failed if number is None else failed.caused_by(system_error(number))


def why_lost(error: Exception, kind: PortKind = PortKind.CABLE) -> Text:
    """Return the reason that follows "the adapter is gone:"."""
    if isinstance(error, SerialTimeoutException | WriteTimeout):
        return TAKES_NO_BYTES
    if kind is PortKind.NETWORK:
        is_closed = isinstance(error, ConnectionError) or number_of(error) == errno.EBADF
        return CLOSED_THERE if is_closed else _why_not_connected(error)
    gone = number_of(error) in _UNPLUGGED or _windows_number(error) in _WINDOWS_UNPLUGGED
    if gone or re.search("disconnected|died", str(error)):
        return UNPLUGGED
    return _own_words(error)


def is_unable(error: Exception) -> bool:
    """Whether `error` means that the port lacks the function, not that it is gone."""
    return isinstance(error, ValueError) or number_of(error) in _NO_TTY


def number_of(error: Exception) -> int | None:
    """Return the system's error number of `error`, or of the error that it wraps."""
    for each in (error, _wrapped(error)):
        if isinstance(each, socket.gaierror):
            return None  # not numbered by errno
        number = each.errno if isinstance(each, OSError) else next(iter(each.args), None)
        if isinstance(number, int):
            return number
    return None


def _why_not_connected(error: Exception) -> Text:
    match error:
        case NotSet():
            return error.text
        case socket.gaierror() | UnicodeError():
            return Text("this host is not known", "такой адрес не найден")
        case BrokenPipeError():
            return CLOSED_THERE
    return _OVER_NETWORK.get(number_of(error) or 0) or _own_words(error)


def _own_words(error: Exception) -> Text:
    """Return the system's own text, without the text that pyserial puts around it."""
    reason = _wrapped(error)
    words = getattr(reason, "strerror", None) or str(reason) or type(reason).__name__
    return Text(words.rstrip("."), words.rstrip("."))


def _windows_number(error: Exception) -> int | None:
    match = _WIN_ERROR.search(str(error))
    return int(match[1]) if match else None


def _wrapped(error: Exception) -> BaseException:
    """Return the error that `error` wraps, or `error` itself.

    pyserial quotes the wrapped error; any other context is an error that the caller was handling.
    """
    inner = error.__cause__ or error.__context__
    return inner if inner is not None and str(inner) and str(inner) in str(error) else error
