"""Commands in the guest of the box, started through `guest_agent.py`."""

from __future__ import annotations

import json
import queue
import socket
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import count
from typing import Any

from usb.wire_rig import PATIENCE


@dataclass(frozen=True, slots=True)
class Done:
    status: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        return json.loads(self.out)


@dataclass(slots=True)
class Command:
    """A command that runs in the guest."""

    words: tuple[str, ...]
    order: Callable[..., None]
    messages: queue.Queue[dict[str, Any]] = field(default_factory=queue.Queue)
    out: str = ""
    err: str = ""
    status: int | None = None
    _yielded: int = 0  # characters of `out`

    def wait(self) -> Done:
        """Return its output and status at its end."""
        while self.status is None:
            self._take()
        return Done(self.status, self.out, self.err)

    def lines(self) -> Iterator[str]:
        """Yield the further lines of its stdout, as they come."""
        while True:
            line, newline, _ = self.out[self._yielded :].partition("\n")
            if newline:
                self._yielded += len(line) + 1
                yield line
            elif self.status is None:
                self._take()
            else:
                return

    def until(self, wanted: Callable[[Any], bool]) -> Any:
        """Return the next JSON line of its stdout that is `wanted`."""
        for line in self.lines():
            if wanted(found := json.loads(line)):
                return found
        raise AssertionError(f"{self.words} ended with {self.status}: {self.out}{self.err}")

    def interrupt(self) -> Done:
        """Press Ctrl-C; return output and status at the end."""
        self.order(signal=2)
        return self.wait()

    def _take(self) -> None:
        try:
            message = self.messages.get(timeout=PATIENCE)
        except queue.Empty:
            raise AssertionError(f"{self.words} says nothing: {self.out}{self.err}") from None
        self.out += message.get("out", "")
        self.err += message.get("err", "")
        self.status = message.get("status")


class Guest:
    """Starts commands through the agent."""

    def __init__(self, end: socket.socket) -> None:
        self._end = end
        self._numbers = count()
        self._running: dict[int, Command] = {}
        self._ready = threading.Event()
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def wait_until_ready(self) -> bool:
        return self._ready.wait(PATIENCE)

    def start(self, words: tuple[str, ...], env: dict[str, str]) -> Command:
        return self._order(words, run=words, env=env)

    def kill_all(self) -> None:
        """End what a failed test left."""
        for command in [it for it in self._running.values() if it.status is None]:
            command.order(signal=9)
            command.wait()
        self._running.clear()

    def drain(self, device: str) -> bool:
        """Return when the reader of `device` has taken what the system holds; False: too slow."""
        return self._order(("drain", device), drain=device).wait().status == 0

    def send_break(self, device: str) -> None:
        """Send a break through `device`."""
        self._order(("break", device), **{"break": device}).wait()

    def port_of(self, place: int) -> str:
        """Wait for the port of the cable in a USB socket, from 1; return its name: `ttyUSB0`."""
        return self._order(("port of", str(place)), port_of=place).wait().out

    def wait_until_gone(self, places: list[int]) -> None:
        """Return when the system has noticed that USB sockets, from 1, are empty."""
        self._order(("gone", *map(str, places)), gone=places).wait()

    def exchange(self, device: str, data: bytes, count: int) -> bytes:
        """Send `data` through `device` at 9600 8N1; return up to `count` bytes that come."""
        send = {"exchange": device, "send": data.hex(), "count": count}
        return bytes.fromhex(self._order(("exchange", device), **send).wait().out)

    def _order(self, words: tuple[str, ...], **first: object) -> Command:
        number = next(self._numbers)

        def order(**what: object) -> None:
            self._end.sendall(json.dumps({"id": number, **what}).encode() + b"\n")

        command = self._running[number] = Command(words, order)
        order(**first)
        return command

    def close(self) -> None:
        self._end.shutdown(socket.SHUT_RDWR)
        self._reader.join(PATIENCE)

    def _read(self) -> None:
        with self._end.makefile("rb") as lines:
            for line in lines:
                message = json.loads(line)
                if "ready" in message:
                    self._ready.set()
                else:
                    self._running[message["id"]].messages.put(message)
