"""Brokers for tests, and a client that listens to one.

amqtt runs in this process; Mosquitto is the real program, started, killed and started again.
"""

from __future__ import annotations

import asyncio
import json
import os
import shutil
import socket
import subprocess
import threading
from collections.abc import Callable, Coroutine, Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import aiomqtt

PATIENCE = 30.0  # s until a test fails that waits for a message
MOSQUITTO = shutil.which("mosquitto", path=f"{os.environ.get('PATH', '')}:/usr/sbin")


def free_port() -> int:
    """Return a port that nobody uses just now."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class _Loop:
    """An event loop in a thread; Windows' usual one can't watch sockets as aiomqtt does."""

    def __init__(self) -> None:
        self._loop = asyncio.SelectorEventLoop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()

    def run(self, work: Coroutine) -> object:
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(PATIENCE)

    def start(self, work: Coroutine) -> asyncio.Future:
        return asyncio.run_coroutine_threadsafe(work, self._loop)

    def close(self) -> None:
        self.run(_cancel_all())
        self.run(asyncio.sleep(0))  # what the tasks closed is closed in the loop's next turn
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(PATIENCE)
        self._loop.close()


async def _cancel_all() -> None:
    tasks = asyncio.all_tasks() - {asyncio.current_task()}
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)


class _Subscriptions(dict):
    """Those of amqtt, which awaits in its loops over them while other clients come and go.

    A dictionary that changed meanwhile made it drop the client that was just connecting.
    """

    def __iter__(self) -> Iterator[str]:
        return iter([*self.keys()])

    def items(self) -> list[tuple[str, list]]:
        return [*super().items()]


class InProcessBroker:
    """amqtt on a free port, open to everybody."""

    def __init__(self) -> None:
        from amqtt.broker import Broker

        class DeliveringBroker(Broker):
            """amqtt drops what a client sent just before its DISCONNECT and still waits here, and
            leaves a connection open whose client broke off before it was a session.
            """

            async def stream_connected(self, reader, writer, listener_name) -> None:
                try:
                    await super().stream_connected(reader, writer, listener_name)
                finally:
                    writer.close()

            async def _client_message_loop(self, client_session, handler) -> None:
                wait = handler.wait_disconnect

                async def wait_until_delivered() -> object:
                    packet = await wait()
                    while not client_session.delivered_message_queue.empty():
                        await asyncio.sleep(0)
                    return packet

                handler.wait_disconnect = wait_until_delivered
                await super()._client_message_loop(client_session, handler)

        self.port = free_port()
        self._loop = _Loop()
        self._broker: Broker | None = None
        anybody = {"amqtt.plugins.authentication.AnonymousAuthPlugin": {"allow_anonymous": True}}
        config = {
            "listeners": {"default": {"type": "tcp", "bind": f"127.0.0.1:{self.port}"}},
            "plugins": anybody,
        }

        async def begin() -> None:
            self._broker = DeliveringBroker(config)
            self._broker._subscriptions = _Subscriptions()  # noqa: SLF001
            await self._broker.start()

        self._loop.run(begin())

    def close(self) -> None:
        self._loop.run(self._broker.shutdown())
        self._loop.close()


class Relay:
    """A port in front of a broker's, which can be cut off as a network is.

    `breaks`: each connection ends with the first bytes behind the handshake.
    """

    def __init__(self, to: int) -> None:
        self.port = free_port()
        self.breaks = False
        self._to = to
        self._loop = _Loop()
        self._server: asyncio.Server | None = None
        self._open: set[asyncio.StreamWriter] = set()
        self.restore()

    def restore(self) -> None:
        async def begin() -> None:
            self._server = await asyncio.start_server(self._serve, "127.0.0.1", self.port)

        self._loop.run(begin())

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        there, out = await asyncio.open_connection("127.0.0.1", self._to)
        self._open |= {writer, out}
        try:
            await asyncio.gather(self._send(reader, out), _copy(there, writer))
        except OSError:
            pass
        finally:
            for each in (writer, out):
                each.close()
            self._open -= {writer, out}

    async def _send(self, reader: asyncio.StreamReader, out: asyncio.StreamWriter) -> None:
        if self.breaks:
            out.write(await reader.read(65536))
            await reader.read(1)
            out.close()
        else:
            await _copy(reader, out)

    def cut(self) -> None:
        """Close the port and all connections."""

        async def end() -> None:
            self._server.close()
            for writer in self._open:
                writer.close()

        self._loop.run(end())

    def close(self) -> None:
        self.cut()
        self._loop.close()


async def _copy(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    while data := await reader.read(65536):
        writer.write(data)
        await writer.drain()
    writer.close()


class Got(NamedTuple):
    """A message as the broker delivers it."""

    topic: str
    payload: bytes
    retain: bool

    @property
    def json(self) -> dict:
        return json.loads(self.payload)


class Listener:
    """Subscribes to all and keeps what comes; connects again after the broker was away."""

    def __init__(self, port: int, **settings: object) -> None:
        self.got: list[Got] = []
        self._port = port
        self._settings = settings
        self._changed = threading.Condition()
        self._subscribed = threading.Event()
        self._loop = _Loop()
        self._task = self._loop.start(self._listen())
        assert self._subscribed.wait(PATIENCE)

    async def _listen(self) -> None:
        while True:
            with suppress(aiomqtt.MqttError):
                async with aiomqtt.Client("127.0.0.1", self._port, **self._settings) as client:
                    await client.subscribe("#", qos=1)
                    self._subscribed.set()
                    async for message in client.messages:
                        with self._changed:
                            got = Got(str(message.topic), message.payload, message.retain)
                            self.got.append(got)
                            self._changed.notify_all()
            self._subscribed.clear()
            await asyncio.sleep(0.05)

    def wait_for(self, wanted: Callable[[Got], bool], *, after: int = 0) -> Got:
        """Return the first message that is `wanted`, of those behind the first `after`."""
        found: list[Got] = []

        def there() -> bool:
            found[:] = [it for it in self.got[after:] if wanted(it)][:1]
            return bool(found)

        with self._changed:
            assert self._changed.wait_for(there, PATIENCE), [it.topic for it in self.got[after:]]
        return found[0]

    def wait_until_subscribed(self) -> None:
        assert self._subscribed.wait(PATIENCE)

    def close(self) -> None:
        self._loop.close()


def is_(topic: str, payload: bytes | None = None, **content: object) -> Callable[[Got], bool]:
    """Return what tells a message of this topic, with this payload or this JSON in it."""

    def wanted(got: Got) -> bool:
        if got.topic != topic or (payload is not None and got.payload != payload):
            return False
        return not content or content.items() <= got.json.items()

    return wanted


class Mosquitto:
    """The real broker. `lines`: of its configuration, behind the listener."""

    def __init__(self, folder: Path, *lines: str) -> None:
        self.port = free_port()
        self._config = folder / "mosquitto.conf"
        lines = lines or ("allow_anonymous true",)
        text = "\n".join([f"listener {self.port} 127.0.0.1", "user root", *lines, ""])
        self._config.write_text(text, "utf-8")
        self._process: subprocess.Popen | None = None
        self.start()

    def start(self) -> None:
        log = self._config.with_suffix(".log").open("wb")
        with log:
            self._process = subprocess.Popen(
                [MOSQUITTO, "-c", self._config], stdout=log, stderr=subprocess.STDOUT
            )
        waiting = threading.Event()
        while self._process.poll() is None:
            with suppress(OSError), socket.create_connection(("127.0.0.1", self.port), 1):
                return
            waiting.wait(0.02)
        raise AssertionError(self._config.with_suffix(".log").read_text("utf-8"))

    def kill(self) -> None:
        self._process.kill()
        self._process.wait(PATIENCE)

    def close(self) -> None:
        if self._process.poll() is None:
            self.kill()
