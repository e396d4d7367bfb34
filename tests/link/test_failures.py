"""What pyserial says on each system, and what we make of it."""

from __future__ import annotations

import errno
import socket

import pytest
from serial import SerialException, SerialTimeoutException

from mikas.errors import PortBusy, PortDenied, PortFailed, PortKind, PortNotFound
from mikas.link import failures
from mikas.link.failures import is_unable, opening_failed, why_lost
from mikas.link.network.rfc2217 import NO_TELNET, NotSet
from mikas.link.network.tcp import ConnectionEnded


def wrapping(inner: Exception, text: str = "could not open port: {}") -> Exception:
    """As pyserial wraps."""
    try:
        try:
            raise inner
        except Exception as error:
            raise SerialException(text.format(error))  # noqa: B904  (as pyserial does it)
    except SerialException as error:
        return error


def windows(reason: str) -> SerialException:
    return SerialException(f"could not open port 'COM3': {reason}")


@pytest.mark.parametrize(
    ("error", "raised"),
    [
        (SerialException(errno.ENOENT, "could not open port"), PortNotFound),
        (SerialException(errno.ENODEV, "could not open port"), PortNotFound),
        (SerialException(errno.EACCES, "could not open port"), PortDenied),
        (SerialException(errno.EPERM, "could not open port"), PortDenied),
        (SerialException(errno.EBUSY, "could not open port"), PortBusy),
        (SerialException(errno.EWOULDBLOCK, "Could not exclusively lock port"), PortBusy),
        (
            windows("FileNotFoundError(2, 'The system cannot find the file.', None, 2)"),
            PortNotFound,
        ),
        (windows("PermissionError(13, 'Access is denied.', None, 5)"), PortBusy),
        (windows("PermissionError(13, 'Отказано в доступе.', None, 5)"), PortBusy),
        (windows("OSError(22, 'The semaphore timeout has expired.', None, 121)"), PortFailed),
        (
            SerialException(
                "Cannot configure port, something went wrong. Original message: "
                "PermissionError(13, 'A device is not functioning.', None, 31)"
            ),
            PortFailed,
        ),
    ],
)
def test_the_reason_decides_the_error(error, raised):
    assert type(opening_failed("COM3", error)) is raised


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (wrapping(OSError(errno.ENOTTY, "Inappropriate ioctl")), "not a serial port"),
        (wrapping(Exception(errno.ENOTTY, "Inappropriate ioctl")), "not a serial port"),
        (wrapping(Exception(errno.EIO, "Input/output error")), "Input/output error"),
        (
            ValueError("Failed to set custom baud rate (12345): no"),
            "Failed to set custom baud rate",
        ),
        (ValueError(), "ValueError"),
    ],
)
def test_other_reasons_are_in_the_message(error, message):
    failed = opening_failed("COM3", error)
    assert isinstance(failed, PortFailed)
    assert message in str(failed)
    assert "не открылся" in failed.text.ru


NETWORK = [
    (ConnectionRefusedError(errno.ECONNREFUSED, "Connection refused"), "no program listens there"),
    (socket.gaierror(-2, "Name or service not known"), "host is not known"),
    (UnicodeError("label empty or too long"), "host is not known"),
    (TimeoutError(errno.ETIMEDOUT, "timed out"), "no answer from there"),
    (OSError(errno.EHOSTUNREACH, "No route to host"), "no answer from there"),
    (OSError(errno.ENETUNREACH, "Network is unreachable"), "has no way to it"),
    (PermissionError(errno.EPERM, "Operation not permitted"), "a firewall"),
    (PermissionError(errno.EACCES, "Permission denied"), "a firewall"),
    (OSError(errno.EMFILE, "Too many open files"), "Too many open files"),
    (NotSet(NO_TELNET), "try socket://"),
]


@pytest.mark.parametrize(("error", "message"), NETWORK)
def test_over_a_network_the_reasons_are_its_own(error, message):
    failed = opening_failed("socket://host:1", error)
    assert isinstance(failed, PortFailed)
    assert message in failed.reason.en
    assert "bridge" in failed.advice.en
    assert message not in failed.reason.ru or message == "Too many open files"
    if not isinstance(error, ConnectionError):
        assert message in why_lost(error, PortKind.NETWORK).en


@pytest.mark.parametrize(
    "error",
    [
        ConnectionEnded(errno.ECONNRESET, "closed"),
        ConnectionResetError(errno.ECONNRESET, "Connection reset by peer"),
        BrokenPipeError(errno.EPIPE, "Broken pipe"),
        OSError(errno.EBADF, "Bad file descriptor"),
    ],
)
def test_a_connection_that_has_ended_was_not_unplugged(error):
    assert why_lost(error, PortKind.NETWORK).en == "closed by the other end"


def test_a_missing_port_lists_those_that_exist(monkeypatch):
    monkeypatch.setattr(failures, "find_ports", list)
    missing = opening_failed("COM9", SerialException(errno.ENOENT, "no"))
    assert "Found: none" in missing.text.en
    assert "Найдены: ни одного" in missing.text.ru


def test_what_the_caller_was_just_handling_is_not_the_reason():
    """An error has as context whatever was being handled when it was raised: a retry, say."""
    try:
        raise OSError(errno.EBUSY, "Device or resource busy")
    except OSError:
        try:
            raise SerialException("Cannot configure port, something went wrong.")
        except SerialException as error:
            failed = opening_failed("COM3", error)
    assert "Cannot configure port, something went wrong" in str(failed)
    assert isinstance(failed, PortFailed)


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (SerialTimeoutException("Write timeout"), "takes no more bytes"),
        (SerialException("device reports readiness … (device disconnected or …?)"), "unplugged"),
        (SerialException("socket disconnected"), "unplugged"),
        (wrapping(OSError(errno.EIO, "Input/output error"), "write failed: {}"), "unplugged"),
        (OSError(errno.ENODEV, "No such device"), "unplugged"),
        (wrapping(OSError(errno.ENOMEM, "Cannot allocate memory"), "read failed: {}"), "allocate"),
        (
            SerialException("ClearCommError failed (PermissionError(13, 'x', None, 22))"),
            "unplugged",
        ),
        (SerialException("ReadFile failed (OSError(22, 'x', None, 999))"), "ReadFile failed"),
    ],
)
def test_why_a_port_in_use_is_gone(error, message):
    assert message in why_lost(error).en
    assert why_lost(error).ru


def test_a_refused_setting_is_told_from_a_failing_port():
    assert is_unable(OSError(errno.ENOTTY, "Inappropriate ioctl"))
    assert is_unable(ValueError("remote rejected value for option 'control'"))
    assert not is_unable(OSError(errno.EIO, "Input/output error"))
