"""The guest's first process: starts commands, reports their output and status.

One JSON object a line, on a virtio port. From the host: `{"id", "run": [...], "env": {...}}`,
`{"id", "signal": 2}`, `{"id", "state": true}`, `{"id", "drain": "/dev/ttyUSB0"}`: wait until its
reader has taken all; `{"id", "break": "/dev/ttyUSB0"}`: send a break; `{"id", "exchange":
"/dev/ttyUSB0", "send": hex, "count"}`: send bytes, and take so many; `{"id", "port_of": 1}`: wait
for the port of the cable in a USB socket, `{"id", "gone": [1, 2]}`: until these are empty. To the
host: `{"ready": true}`, `{"id", "out": text}`, `{"id", "err": text}`, `{"id", "state": {"time",
"rss"}}`, the guest's UNIX time and the command's KiB in memory, `{"id", "status": 0}`.

`mikas` is imported once, here, with its catalog, and each of its commands is a fork of this
process: under emulation an interpreter takes five seconds to start, and what every command loads
three more. So this process has no threads. It waits for ports itself, which needs no fork.
"""

from __future__ import annotations

import fcntl
import gc
import json
import os
import select
import selectors
import signal
import sys
import termios
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import NoReturn

NAME = "mikas.agent"
PAUSES = "PAUSES"
"""Variable of `env`: for how many seconds the computer may stop, and `mikas` not notice."""
_READ_WITHIN = 20.0  # s; meanwhile nothing else is done here
_EACH = 0.02  # s between two looks at what is waited for
_USED = (
    "importlib.resources", "locale", "mikas.catalog.ignition_only", "mikas.catalog.own.file",
    "mikas.cli.commands.doctor", "mikas.cli.commands.groups", "mikas.cli.commands.log",
    "mikas.cli.commands.memory.cells", "mikas.cli.commands.memory.files",
    "mikas.cli.commands.ports", "mikas.cli.commands.unit.parameters", "mikas.cli.commands.watch",
    "mikas.cli.main", "mikas.cli.render.live_table", "mikas.cli.render.notices",
    "mikas.cli.sampling_run", "mikas.client.doctor", "mikas.cli.port_ahead", "mikas.link.serial",
    "mikas.link.udev_rules", "mikas.recording.export", "mikas.recording.table",
    "serial.tools.list_ports",
)  # fmt: skip


@dataclass(slots=True)
class Process:
    number: int
    pid: int
    open_ends: set[int] = field(default_factory=set)


class Agent:
    def __init__(self, port: int) -> None:
        self._port = port
        self._selector = selectors.DefaultSelector()
        self._processes: dict[int, Process] = {}
        self._waits: dict[int, Callable[[], str | None]] = {}

    def serve(self) -> None:
        self._selector.register(self._port, selectors.EVENT_READ, self._receive)
        self._pending = b""
        self._send(ready=True)
        while True:
            for key, _ in self._selector.select(_EACH if self._waits else None):
                key.data()
            for number, look in list(self._waits.items()):
                if (found := look()) is not None:
                    self._end_wait(number, 0, found)

    def _receive(self) -> None:
        data = os.read(self._port, 4096)
        if not data:  # the tests were ended: without its first process the guest ends, and QEMU
            sys.exit()
        *lines, self._pending = (self._pending + data).split(b"\n")
        for line in lines:
            order = json.loads(line)
            if "run" in order:
                self._run(order["id"], order["run"], order["env"])
            elif "drain" in order:
                self._send(id=order["id"], status=0 if drain(order["drain"]) else 1)
            elif "exchange" in order:
                got = exchange(order["exchange"], bytes.fromhex(order["send"]), order["count"])
                self._send(id=order["id"], out=got.hex())
                self._send(id=order["id"], status=0)
            elif "port_of" in order:
                self._waits[order["id"]] = lambda place=order["port_of"]: port_of(place)
            elif "gone" in order:
                self._waits[order["id"]] = lambda places=order["gone"]: gone(places)
            elif order["id"] in self._waits:
                self._end_wait(order["id"], -order["signal"])
            elif "break" in order:
                send_break(order["break"])
                self._send(id=order["id"], status=0)
            elif (process := self._processes.get(order["id"])) is not None:
                if "state" in order:
                    self._send(id=order["id"], state=state_of(process.pid))
                else:
                    os.kill(process.pid, order["signal"])

    def _end_wait(self, number: int, status: int, found: str = "") -> None:
        del self._waits[number]
        self._send(id=number, out=found)
        self._send(id=number, status=status)

    def _run(self, number: int, words: list[str], env: dict[str, str]) -> None:
        out, err = os.pipe(), os.pipe()
        pid = os.fork()
        if pid == 0:
            os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
            os.dup2(out[1], 1)
            os.dup2(err[1], 2)
            os.closerange(3, 64)
            execute(words, env)
        process = self._processes[number] = Process(number, pid)
        for kind, (end, theirs) in (("out", out), ("err", err)):
            os.close(theirs)
            process.open_ends.add(end)
            stream = Stream(self, process, kind, end)
            self._selector.register(end, selectors.EVENT_READ, stream.read)

    def pass_on(self, process: Process, kind: str, text: str) -> None:
        self._send(**{"id": process.number, kind: text})

    def ended(self, process: Process, end: int) -> None:
        self._selector.unregister(end)
        os.close(end)
        process.open_ends.discard(end)
        if not process.open_ends:
            _, status = os.waitpid(process.pid, 0)
            del self._processes[process.number]
            self._send(id=process.number, status=os.waitstatus_to_exitcode(status))

    def _send(self, **message: object) -> None:
        data = json.dumps(message).encode() + b"\n"
        while data:
            data = data[os.write(self._port, data) :]


@dataclass(slots=True)
class Stream:
    """A command's stdout or stderr, passed on by whole lines."""

    agent: Agent
    process: Process
    kind: str
    end: int
    pending: bytes = b""

    def read(self) -> None:
        data = os.read(self.end, 65536)
        lines, newline, self.pending = (self.pending + data).rpartition(b"\n")
        whole = lines + newline if data else lines + newline + self.pending
        if whole:
            self.agent.pass_on(self.process, self.kind, whole.decode(errors="replace"))
        if not data:
            self.agent.ended(self.process, self.end)


def execute(words: list[str], env: dict[str, str]) -> NoReturn:
    """Be the command `words` from here on."""
    os.setsid()
    signal.signal(signal.SIGINT, signal.default_int_handler)
    os.environ.clear()
    os.environ.update(env)
    os.chdir(env["HOME"])
    try:
        if words[0] != "mikas":
            os.execvpe(words[0], words, env)
        from mikas.cli.main import main

        if seconds := env.get(PAUSES):
            allow_pauses(float(seconds))
        main(words[1:])
    except SystemExit as end:
        sys.stdout.flush()
        os._exit(end.code if isinstance(end.code, int) else 1)
    except BaseException:
        traceback.print_exc()
        sys.stderr.flush()
    os._exit(127)


def allow_pauses(seconds: float) -> None:
    """Let stops of the emulated computer pass, which would cost an exchange (D14).

    A value may then be older than its time says, which no test of the box compares.
    """
    from mikas.link.suspension import SuspensionGuard

    SuspensionGuard.__init__.__defaults__ = (seconds,)


def state_of(pid: int) -> dict[str, float]:
    """Return the time, and the memory of a process; 0 of an ended one."""
    lines = Path(f"/proc/{pid}/status").read_text("utf-8").splitlines()
    sizes = (int(line.split()[1]) for line in lines if line.startswith("VmRSS:"))
    return {"time": time.time(), "rss": next(sizes, 0)}


def port_of(place: int) -> str | None:
    """Return the name of the port that the cable in a USB socket has, once it has one."""
    interface = f"/1-{place}:1.0"
    ttys = Path("/sys/class/tty")
    for port in (*ttys.glob("ttyUSB*"), *ttys.glob("ttyACM*")):
        device = f"{os.path.realpath(port / 'device')}/"
        if f"{interface}/" in device and Path("/dev", port.name).is_char_device():
            return port.name
    return None


def gone(places: list[int]) -> str | None:
    """Return "" once the system has noticed that USB sockets are empty."""
    devices = (Path(f"/sys/bus/usb/devices/1-{place}") for place in places)
    return None if any(map(os.path.lexists, devices)) else ""


def drain(port: str) -> bool:
    """Wait until the system holds no bytes of `port` for its reader; False: it does not read."""
    number = os.open(port, os.O_RDONLY | os.O_NOCTTY | os.O_NONBLOCK)  # root may, despite TIOCEXCL
    end = time.monotonic() + _READ_WITHIN
    while left := fcntl.ioctl(number, termios.FIONREAD, bytes(4)) != bytes(4):
        if time.monotonic() > end:
            break
        time.sleep(0.001)  # in the guest, in real time: nothing reports that a reader took bytes
    os.close(number)
    return not left


def send_break(port: str) -> None:
    """Send a break of a quarter of a second, as a program does."""
    number = os.open(port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    termios.tcsendbreak(number, 0)
    os.close(number)


def exchange(port: str, data: bytes, count: int) -> bytes:
    """Send `data` at 9600 8N1, and return up to `count` bytes that come."""
    number = os.open(port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    mode = [0, 0, termios.CS8 | termios.CREAD | termios.CLOCAL, 0, termios.B9600, termios.B9600]
    termios.tcsetattr(number, termios.TCSANOW, [*mode, [b"\0"] * 32])
    os.write(number, data)
    got, end = b"", time.monotonic() + _READ_WITHIN
    while len(got) < count and (left := end - time.monotonic()) > 0:
        if select.select([number], [], [], left)[0]:
            got += os.read(number, count)
    os.close(number)
    return got


def import_mikas() -> None:
    """Load what the commands use; more than that would only delay the boot."""
    for module in _USED:
        import_module(module)
    from mikas.catalog import shipped
    from mikas.link.urls import registered

    shipped()
    registered()
    gc.freeze()  # a fork does not touch what is frozen


def open_port() -> int:
    for name in Path("/sys/class/virtio-ports").glob("*/name"):
        if name.read_text("ascii").strip() == NAME:
            return os.open(f"/dev/{name.parent.name}", os.O_RDWR)
    raise FileNotFoundError(NAME)


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    import_mikas()
    Agent(open_port()).serve()
