"""The whole program, as `mikas dash` runs it, over a virtual car whose time runs fast: a real
server on a real socket, real threads. In Pyodide, as the site runs it (tests/on_pyodide): answered
by messages, on the site's threads. Tests wait for what comes, never for time to pass.
"""

from __future__ import annotations

import json
import sys
import threading
import time
from contextlib import contextmanager
from urllib.parse import parse_qsl

from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.settings import PlanSettings, Settings
from mikas.errors import PortNotFound
from mikas.link import WallClock
from mikas.link.ports import Port
from mikas.link.virtual import RealTimeVirtualLink
from mikas.virtual.build import build_bus

if sys.platform == "emscripten":
    from dashboard.page_rig import served
else:
    from dashboard.server_rig import served

SPEED = 20
STALL = 0.5  # s of the fast time
ME = {"X-Mikas-Client": "tester-0001", "X-Mikas-Name": "Me"}
OTHER = {"X-Mikas-Client": "tester-0002", "X-Mikas-Name": "%D0%92%D0%B0%D1%81%D1%8F"}
NAMES = ("FREQ", "TWAT", "UACC", "INJ", "DET", "FUEL_FLOW")
ADAPTER = Port("/dev/ttyUSB7", "FT232R USB UART (FTDI)", "FT232R", likely=True)


class FastClock:
    """UNIX time that passes up to `SPEED` times as fast.

    A machine that stalls lets at most `STALL` pass: else a tenth of a second without this process
    were a silence of two seconds on the line, in which no program can get its values.
    """

    def __init__(self):
        self._lock = threading.Lock()
        self._now = time.time()
        self._asked = time.perf_counter()
        self.set_by = 0.0
        """The seconds by which the computer's date was set."""

    def now(self):
        with self._lock:
            asked = time.perf_counter()
            self._now += min((asked - self._asked) * SPEED, STALL)
            self._asked = asked
            return self._now

    def date(self):
        """The computer's date."""
        return self.now() + self.set_by

    def sleep(self, seconds):
        """The computer was asleep for so long."""
        with self._lock:
            self._now += seconds


class _FastGone(threading.Event):
    def wait(self, timeout=None):
        return super().wait(None if timeout is None else timeout / SPEED)


class FastLink(RealTimeVirtualLink):
    """A virtual unit on a `FastClock`."""

    def __init__(self, bus, url, clock):
        super().__init__(bus, url=url)
        self._clock = clock
        self._gone = _FastGone()

    def now(self):
        return self._clock.now()

    def date(self):
        return self._clock.date()


class Cars:
    """What the ports of this computer lead to. The same port leads to the same car."""

    def __init__(self):
        self.clock = FastClock()
        self.links = []
        self.ports = [ADAPTER]
        self.pulled = False
        self._buses = {}

    def open(self, url):
        if self.pulled or (not url.startswith("sim:") and url not in [p.url for p in self.ports]):
            raise PortNotFound(url=url, found="none")
        settings = dict(parse_qsl(url.partition("?")[2]))
        if url not in self._buses:
            self._buses[url] = build_bus(settings, start=self.clock.now())
        link = FastLink(self._buses[url], url, self.clock)
        self.links.append(link)
        return link

    def car(self, url):
        """The virtual unit's car behind `url`."""
        return self._buses[url].ecu.responder.car

    def park(self, car, url):
        """From here on the car of the URL `car` stands behind `url`."""
        self._buses[url] = build_bus(dict(parse_qsl(car.partition("?")[2])), start=self.clock.now())

    def pull(self):
        """The adapter is pulled out."""
        self.pulled = True
        self.links[-1].unplug()

    def put_back(self):
        self.pulled = False


class Rig:
    def __init__(self, dashboard, cars, reached):
        self.dashboard, self.cars = dashboard, cars
        self.access, self.client, self.server = reached.access, reached.client, reached.server
        self.port = self.access.port
        self.reached, self._open = reached, reached.open

    def get(self, path, status=200, headers=ME, **params):
        return self._checked(self.client.get(f"/api{path}", headers=headers, params=params), status)

    def post(self, path, body=None, status=200, headers=ME):
        answer = self.client.post(f"/api{path}", json={} if body is None else body, headers=headers)
        return self._checked(answer, status)

    def put(self, path, body, status=200, headers=ME):
        return self._checked(self.client.put(f"/api{path}", json=body, headers=headers), status)

    def delete(self, path, status=200, headers=ME, **params):
        return self._checked(
            self.client.delete(f"/api{path}", headers=headers, params=params), status
        )

    def _checked(self, answer, status):
        assert answer.status_code == status, answer.text
        if status >= 400:
            return answer.json()["error"]
        return answer.json() if "json" in answer.headers["content-type"] else answer

    @contextmanager
    def live(self, client="watcher-0001", headers=None, **extra):
        query = "&".join(f"{name}={value}" for name, value in {"client": client, **extra}.items())
        with self._open(f"/api/live?{query}", headers) as socket:
            yield Live(socket)

    def until(self, accepted):
        """The first live message of which `accepted(message)` is true."""
        with self.live(client="waiting-0001") as live:
            return live.until(accepted)

    def sampling(self):
        """Waits until values come, and the unit is known; returns their state.

        A message may have the first values with the state from just before.
        """
        return self.until(lambda it: "data" in it and (it.get("state") or {}).get("model"))["state"]


class Live:
    """A WebSocket of the application; remembers the last state."""

    def __init__(self, socket):
        self.socket = socket
        self.state = None

    def next(self):
        message = json.loads(self.socket.recv(60))
        self.state = message.get("state", self.state)
        return message

    def until(self, accepted):
        for _ in range(2000):
            message = self.next()
            message["state"] = self.state
            if accepted(message):
                return message
        raise AssertionError("it never came")

    def send(self, value):
        self.socket.send(json.dumps(value))


@contextmanager
def rig(
    tmp_path,
    begin="sim:",
    *,
    names=NAMES,
    method="batch",
    rate=5,
    page=None,
    language=None,
    desktop=False,
    tls=None,
    **access,
):
    cars = Cars()
    settings = Settings(
        tmp_path / "recordings",
        state=tmp_path / "state",
        find=lambda: list(cars.ports),
        open_port=cars.open,
        wall=WallClock(cars.clock.now, cars.clock.date),
        addresses=lambda: ("127.0.0.2", "garage"),
        language=language,
        desktop=desktop,
        tests=tmp_path / "tests",
        causes=tmp_path / "causes",
        sockets=sys.platform != "emscripten",
    )
    dashboard = Dashboard(settings, port=begin, lan=access.get("lan", False))
    dashboard.plan.request = PlanSettings(dict.fromkeys(names, 1), method, rate)
    with served(dashboard, page or tmp_path / "page", tls, access) as reached:
        yield Rig(dashboard, cars, reached)
