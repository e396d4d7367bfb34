"""The dashboard as it is served, and a person's tab on it.

The program runs in this process, on a real socket, over virtual cars in real time; what stands
behind which port, and what the units hold, is looked at and changed from here.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from urllib.parse import urlencode

import httpx
from playwright.sync_api import BrowserContext, Locator, Page, expect
from websockets.sync.client import connect

from mikas.catalog import shipped
from mikas.dashboard.app import create_app
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.network.listening import listen
from mikas.dashboard.security.access import Access
from mikas.dashboard.security.certificate import own_certificate
from mikas.dashboard.server import Server
from mikas.dashboard.settings import PlanSettings, Settings
from mikas.errors import PortNotFound
from mikas.link import open_link
from mikas.link.ports import Port
from mikas.link.virtual import RealTimeVirtualLink

SCREENS = (
    "live", "chart", "faults", "tests", "causes", "passport", "memory", "recordings",
    "report", "connection",
)  # fmt: skip
FT232 = Port("/dev/ttyUSB7", "FT232R USB UART (FTDI)", "FT232R", likely=True)
CAR = """\
duration = 60
faults = [17, 41]
passports = ["M71 PROG", "17.3763.000-02", "V1.2", "M71 DATA", "A", "B", "C", "D"]

[start]
coolant = 88
running = true

[values]
TWAT = 87
UACC = 13.8
INJ = 4.64
THR = 0
RXX = true
DET = false

[raw]
JAIR = "DC 05"
UOZ = "F9"

[memory.xram]
8000 = "4D 49 4B 41 53 20 37 2E 31 0D 40 0A FF 00 10 80"
"""
"""A car whose values stand still, but for the speed: the engine lives. JAIR 15.0, UOZ −3.5."""
LAPTOP = "laptop.test"  # at 127.0.0.2, which is not where a dashboard speaks plain HTTP
"""How the network calls this computer; the browser resolves it to 127.0.0.1. As from every
plain http address but the loopback's own, pages from there have no secure context.
"""
UNTIL = 60_000
"""ms that anything may take on a slow machine; nothing waits longer than it has to."""

expect.set_options(timeout=UNTIL)


class Garage:
    """What this computer's ports lead to. The same port leads to the same car."""

    def __init__(self, folder: Path) -> None:
        self._scenario = folder / "car.toml"
        self._scenario.write_text(CAR, "utf-8")
        self.ports = [FT232]
        self._settings = {FT232.url: {"scenario": str(self._scenario)}}
        self._buses = {}
        self._links = []

    def plug(self, url: str, chip: str, **settings: str) -> None:
        """One more adapter."""
        self.ports.append(Port(url, chip, chip, likely=True))
        self._settings[url] = {"scenario": str(self._scenario), **settings}

    def key_off(self) -> str:
        """A scenario with the ignition off."""
        file = self._scenario.with_name("off.toml")
        file.write_text(f"{CAR}\n[timeline]\nkey = 0\n", "utf-8")
        return str(file)

    def tune(self, **settings: str) -> None:
        """Another car behind the first adapter."""
        self._settings[FT232.url] |= settings

    def pull(self) -> None:
        """All adapters are out."""
        self._gone, self.ports = self.ports, []
        for link in self._links:
            link.unplug()

    def put_back(self) -> None:
        self.ports = self._gone

    def open(self, url: str):
        if url not in self._settings:
            return open_link(url)
        if url not in [port.url for port in self.ports]:
            raise PortNotFound(url=url, found="none")
        if url not in self._buses:
            self._buses[url] = open_link(f"sim:?{urlencode(self._settings[url])}").bus
        link = RealTimeVirtualLink(self._buses[url], url=url)
        self._links.append(link)
        return link

    @property
    def car(self):
        return self._buses[FT232.url].ecu.responder.car

    @property
    def memory(self):
        return self._buses[FT232.url].ecu.responder.memory

    def set(self, name: str, raw: str) -> None:
        """The car's datum from now on."""
        self.car.write(shipped().parameter(name).code, bytes.fromhex(raw))


class Dash:
    """The program, served; `api` asks it as one more client."""

    def __init__(
        self, dashboard: Dashboard, garage: Garage, access: Access, api: httpx.Client
    ) -> None:
        self.dashboard, self.garage, self.access, self.api = dashboard, garage, access, api
        self.url = access.url.rstrip("/")
        self.port = access.port

    def state(self) -> dict:
        return self.get("/state")

    def get(self, path: str) -> dict:
        return self.api.get(f"/api{path}").raise_for_status().json()

    def post(self, path: str, body: dict | None = None) -> dict:
        return self.api.post(f"/api{path}", json=body or {}).raise_for_status().json()

    def put(self, path: str, body: dict) -> dict:
        return self.api.put(f"/api{path}", json=body).raise_for_status().json()

    def until(self, accepted: Callable[[], bool]) -> None:
        """Until `accepted()`, looked at with every message of the live line."""
        url = f"{self.url.replace('http', 'ws')}/api/live?client=waiting-0001"
        with connect(url, open_timeout=60) as live:
            for _ in range(1200):
                live.recv(60)
                if accepted():
                    return
        raise AssertionError("it never came")

    @contextmanager
    def onlooker(self) -> Iterator[None]:
        """One more who looks on meanwhile, and keeps up."""
        url = f"{self.url.replace('http', 'ws')}/api/live?client=onlooker-0001"
        with connect(url, open_timeout=60) as live:
            reading = threading.Thread(target=lambda: deque(live, maxlen=0))
            reading.start()
            try:
                yield
            finally:
                live.close()
                reading.join()

    def samples(self) -> Dash:
        """Waits until it does."""
        self.until(lambda: self.state()["samples"] > 3)
        return self

    def later(self, seconds: float) -> None:
        """People's time has passed: that of the seat, of confirmations, of the lock."""
        clock = self.dashboard.clock
        assert isinstance(clock, PeoplesClock)
        clock.ahead += seconds

    def nobody_controls(self) -> None:
        """The seat is free at once, not seconds after its holder has gone."""
        self.post("/control/take", {"force": True})
        self.post("/control/release")


class PeoplesClock:
    """Seconds that never run back, and can be pushed ahead."""

    def __init__(self) -> None:
        self.ahead = 0.0

    def __call__(self) -> float:
        return time.monotonic() + self.ahead


@contextmanager
def dashboard(
    folder: Path,
    *,
    begin: bool = True,
    port: int = 0,
    garage: Garage | None = None,
    lan: bool = False,
    lan_control: bool = False,
    desktop: bool = False,
    **settings: str,
) -> Iterator[Dash]:
    """The program with the page that was built; `begin`: connected to the first adapter.

    `port` and `garage`: those of a program that has ended, started again. `lan`: for the network,
    which calls this computer `LAPTOP`. `desktop`: an icon has started it.
    """
    garage = garage or Garage(folder)
    garage.tune(**settings)
    dashboard = Dashboard(
        Settings(
            folder / "recordings",
            state=folder / "state",
            find=lambda: list(garage.ports),
            open_port=garage.open,
            addresses=lambda: ("127.0.0.2", LAPTOP),
            tests=folder / "tests",
            desktop=desktop,
        ),
        port=FT232.url if begin else None,
        lan=lan,
        clock=PeoplesClock(),
    )
    every = dashboard.plan.request.every
    # The methods need not be tested, and sampling is not as fast as possible.
    dashboard.plan.request = PlanSettings(every, "batch", 12)
    hosts = (LAPTOP,) if lan else ()
    made = own_certificate(folder / "dashboard.pem", hosts, datetime.now(UTC)) if lan else None
    with listen(port, lan=lan) as own:
        access = Access(
            own.getsockname()[1],
            lan=lan,
            lan_control=lan_control,
            hosts=hosts,
            fingerprint=made.fingerprint if made else None,
        )
        ready = threading.Event()
        app = create_app(dashboard, access, certificate=made)
        server = Server(app, ready=ready.set, tls=made.context if made else None)
        thread = threading.Thread(target=server.run, kwargs={"sockets": [own]})
        thread.start()
        try:
            assert ready.wait(60)
            me = {"X-Mikas-Client": "tester-0001", "X-Mikas-Name": "Me"}
            with httpx.Client(base_url=access.url, headers=me, timeout=60) as api:
                yield Dash(dashboard, garage, access, api)
        finally:
            server.should_exit = True
            thread.join()


class Tab:
    """A tab of the browser. `complaints`: what the browser's console has against the page."""

    def __init__(self, page: Page, url: str) -> None:
        self.url = url.rstrip("/")
        self.complaints: list[str] = []
        self.refused = False
        """Whether the program is expected to refuse something: the console reports that, too."""
        self.attend(page)

    def attend(self, page: Page) -> None:
        """Go on in this page."""
        self.page = page
        page.set_default_timeout(UNTIL)
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.on("console", self._heard)

    def _heard(self, message) -> None:
        refusal = "Failed to load resource" in message.text or "WebSocket" in message.text
        if message.type in ("error", "warning") and not (refusal and self.refused):
            self.complaints.append(f"{message.text} ({message.location.get('url')})")

    def show(self, screen: str) -> Tab:
        """Opens the page there, or goes there; `screen`: also with what it shows, `causes/a`."""
        if self.page.url.startswith(self.url):
            self.page.evaluate("where => { location.hash = where }", f"/{screen}")
        else:
            self.page.goto(f"{self.url}/#/{screen}")
        link = self.page.locator(f'nav a[data-screen="{screen.partition("/")[0]}"]')
        expect(link).to_have_attribute("aria-current", "page")
        return self

    def find(self, selector: str, **how) -> Locator:
        return self.page.locator(selector, **how)

    def button(self, name: str, **how) -> Locator:
        return self.page.get_by_role("button", name=name, **how)

    def press(self, name: str, **how) -> None:
        self.button(name, **how).click()

    def value(self, name: str) -> Locator:
        """The channel's value as it is read on Live."""
        return self.page.locator(f'#screen [data-value="{name}"]').first

    def traced(self, name: str) -> Locator:
        """The channel's value in the chart's legend."""
        return self.page.locator(f'[data-trace="{name}"] b')

    @property
    def line(self) -> Locator:
        """The band's words about the line."""
        return self.page.locator("header[data-line] .line strong")

    def is_line(self, state: str) -> None:
        expect(self.page.locator("header[data-line]")).to_have_attribute("data-line", state)

    def says(self, text: str) -> None:
        expect(self.page.get_by_text(text).first).to_be_visible()

    def comes_first(self, name: str) -> None:
        """Waits until the channel comes first. The page asks: whoever waits on the live line is
        one more viewer, and beside another viewer a page requests only what a person selects.
        """
        asked = "async name => (await (await fetch('/api/state')).json()).plan.first.includes(name)"
        self.until(asked, name)

    def until(self, function: str, given: object = None):
        """Waits for what the function gives to be true in the page; gives that."""
        return until(self.page, function, given)


def gaps_of(program: Dash | Tab, recording: dict) -> list[str]:
    """The reasons of the gaps in a recording, without those of a computer that was too busy."""
    events = program.get(f"/recordings/{recording['id']}")["events"]
    reasons = [event["reason"]["en"] for event in events if event["kind"] == "gap"]
    return [reason for reason in reasons if "The program did not run" not in reason]


def until(page: Page, function: str, given: object = None):
    """Waits for what the function, which may be async, gives to be true in the page; gives that.

    Playwright's own `wait_for_function` takes a promise for true before it is kept.
    """
    waiting = f"""async ([given, until]) => {{
      while (performance.now() < until) {{
        const found = await ({function})(given)
        if (found) return {{ found }}
        await new Promise(again => setTimeout(again, 10))
      }}
    }}"""
    answer = page.evaluate(waiting, [given, page.evaluate("() => performance.now()") + UNTIL])
    assert answer, f"it never came: {function}"
    return answer["found"]


@contextmanager
def tab_in(context: BrowserContext, url: str) -> Iterator[Tab]:
    tab = Tab(context.new_page(), url)
    try:
        yield tab
    finally:
        tab.page.close()
    assert not tab.complaints, tab.complaints
