"""Terminal servers with their faults, as real sockets: the far end of `rfc2217://` and others."""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field

from mikas.link.network.telnet import (
    Negotiation,
    Subnegotiation,
    TelnetDecoder,
    Verb,
    escaped,
    negotiation,
    subnegotiation,
)

COM_PORT, BINARY, ECHO = 44, 0, 1
PATIENCE = 30.0

# The line of a unit: each `01` comes back as its echo, and is answered by the version code.
REQUEST, ANSWER = b"\x01\xff\r", b"\x09\xf7\r"


@contextmanager
def served(talk: Callable[[socket.socket], object], host: str = "127.0.0.1") -> Iterator[str]:
    """Serve each client by `talk`, in a thread of its own; give `host:port`."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    clients: list[socket.socket] = []

    def serve_one(client: socket.socket) -> None:
        with suppress(OSError), client:
            talk(client)

    def serve() -> None:
        with suppress(OSError):
            while True:
                client, _ = server.accept()
                client.settimeout(PATIENCE)
                clients.append(client)
                thread = threading.Thread(target=serve_one, args=(client,), daemon=True)
                threads.append(thread)
                thread.start()

    threads: list[threading.Thread] = []
    with socket.create_server((host, 0), family=family) as server:
        accepting = threading.Thread(target=serve, daemon=True)
        accepting.start()
        port = server.getsockname()[1]
        try:
            yield f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
        finally:
            with suppress(OSError):
                server.shutdown(socket.SHUT_RDWR)
            for client in clients:
                with suppress(OSError):
                    client.shutdown(socket.SHUT_RDWR)
            for thread in (accepting, *threads):
                thread.join(PATIENCE)


def unit(client: socket.socket) -> None:
    """A raw TCP port of a bridge, and the unit behind it."""
    while data := client.recv(4096):
        client.sendall(data + ANSWER * data.count(REQUEST))


@dataclass
class TerminalServer:
    """A server of RFC 2217. `refuses`: options of Telnet; `silent`: commands without an answer.

    `rate`: what it answers for any baud rate. `doubles_ff`, `adds_nul`: how it writes data.
    `greets`: what it sends first. `settings`: by command, what the client has asked for.
    """

    refuses: tuple[int, ...] = ()
    silent: tuple[int, ...] = ()
    rate: int | None = None
    doubles_ff: bool = True
    adds_nul: bool = False
    greets: bytes = b""
    settings: dict[int, list[bytes]] = field(default_factory=dict)

    def __call__(self, client: socket.socket) -> None:
        client.sendall(self.greets)
        decoder = TelnetDecoder(COM_PORT)
        while received := client.recv(4096):
            data, events = decoder.feed(received)
            for event in events:
                client.sendall(self._answer(event))
            if data:
                client.sendall(self._written(data + ANSWER * data.count(REQUEST)))

    def _written(self, data: bytes) -> bytes:
        data = escaped(data) if self.doubles_ff else data
        return data.replace(b"\r", b"\r\0") if self.adds_nul else data

    def _answer(self, event: Negotiation | Subnegotiation) -> bytes:
        match event:
            case Negotiation(Verb.DO | Verb.WILL as verb, option):
                able = option not in self.refuses
                if verb is Verb.DO:
                    return negotiation(Verb.WILL if able else Verb.WONT, option)
                return negotiation(Verb.DO if able else Verb.DONT, option)
            case Subnegotiation(option, data) if option == COM_PORT:
                code, value = data[0], data[1:]
                self.settings.setdefault(code, []).append(value)
                if code in self.silent:
                    return b""
                if code == 1 and self.rate is not None:
                    value = self.rate.to_bytes(4, "big")
                return subnegotiation(COM_PORT, bytes([code + 100]) + value)
        return b""
