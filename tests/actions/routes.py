"""Every route of the API, each with a request that succeeds on a virtual car."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any, Literal

Kept = SimpleNamespace
"""What rows took from their answers, by name: for the addresses and bodies of later rows."""
Home = Literal["desktop", "site"]


def _always(answer: Any) -> bool:
    return True


@dataclass(frozen=True, kw_only=True)
class Row:
    """One request. `route`: as the API names it; `address`: what is asked, of what was kept."""

    method: str
    route: str
    address: str = ""
    body: Any = None
    """JSON or bytes, or a function of what was kept that gives either."""
    status: int = 200
    until: Callable[[Any], bool] = _always
    """Asked again until the answer is accepted."""
    takes: Mapping[str, Callable[[Any], Any]] = field(default_factory=dict)
    homes: tuple[Home, ...] = ("desktop", "site")


def get(route: str, address: str = "", **more: Any) -> Row:
    return Row(method="GET", route=route, address=address, **more)


def post(route: str, body: Any = None, address: str = "", **more: Any) -> Row:
    return Row(method="POST", route=route, address=address, body=body, **more)


def put(route: str, body: Any, address: str = "", **more: Any) -> Row:
    return Row(method="PUT", route=route, address=address, body=body, **more)


def delete(route: str, address: str = "", **more: Any) -> Row:
    return Row(method="DELETE", route=route, address=address, **more)


def change(body: Any) -> tuple[Row, Row]:
    """Return a change's two steps: what it would do, and that it is done."""
    return (
        post("/changes", body, takes={"nonce": lambda it: it["nonce"]}),
        post("/changes/{nonce}", address="/changes/{nonce}"),
    )


def samples(state: Any) -> bool:
    return state["line"] == "sampling" and state["samples"] > 3 and bool(state["version_code"])


def dump_is(*states: str) -> Callable[[Any], bool]:
    return lambda dump: dump["state"] in states


def first_marker(recording: Any) -> float:
    return next(it["time"] for it in recording["events"] if it["kind"] == "marker")


FOREIGN = b"Time (s),AFR\n0,14.7\n1,13.9\n"
CAR = "sim:?scenario=warm-idle"
DOUBLE = {"formula": "TWAT * 2", "text": {"en": "double", "ru": "вдвое"}, "new": True}
GAUGE = {"gauge": [0, 150]}
BOOST = {
    "text": {"en": "Boost gauge", "ru": "Манометр наддува"},
    "patterns": ["{BOOST}"],
    "channels": [{"name": "BOOST", "text": {"en": "Boost", "ru": "Наддув"}, "unit": "bar"}],
}
NAMED = {"car": "Волга", "plate": "A 123 BC", "mileage": 120000, "workshop": ""}
ONE = "/recordings/{recording}"
DUMP = "/dumps/{dump}"
IDENTITY = {"dump": lambda it: it["id"]}
REFERENCES = tuple(
    f"/recordings/virtual:{drive}:{model}"
    for drive in ("warm-idle", "warm-up", "drive")
    for model in ("5.4", "7.1")
)

BEGIN = (
    post("/control/take", {"force": True}),
    get("/about"),
    get("/about/qr.svg", "/about/qr.svg?address=nowhere", status=404),
    put("/network", {"on": False}),
    post("/end", status=409),
    get("/ports"),
    get("/virtual-cars"),
    get("/virtual-cars/answer", "/virtual-cars/answer?car=blind:7"),
    post("/connect", {"port": CAR}),
    get("/state", until=samples),
)
LIVE = (
    get("/catalog", takes={"catalog": lambda it: it["version"]}),
    get("/presets", takes={"presets": lambda it: it["presets"]}),
    put("/presets", lambda kept: {"presets": kept.presets[:1]}),
    get("/history", "/history?seconds=60&points=100"),
    put("/plan", {"wanted": [{"name": "TWAT"}, {"name": "FREQ"}]}),
    put("/plan/first", {"names": ["TWAT"]}),
    post("/plan/price", {"wanted": [{"name": "TWAT"}]}),
    post("/relearn"),
    put("/channels/{name}", DOUBLE, "/channels/DOUBLE"),
    get("/catalog", takes={"catalog": lambda it: it["version"]}),
    delete("/channels/{name}", "/channels/DOUBLE?version={catalog}"),
    put("/channels/{name}/keys", GAUGE, "/channels/TWAT/keys"),
    get("/catalog", takes={"catalog": lambda it: it["version"]}),
    delete("/channels/{name}/keys", "/channels/TWAT/keys?keys=gauge&version={catalog}"),
    get("/channels/{name}/value", "/channels/TWAT/value"),
    post("/channels/try", {"formula": "TWAT / 2"}),
    get("/causes"),
    get("/trip"),
    get("/trip/{form}", "/trip/gpx", status=400),  # no GPS beside this car
    get("/history/find", "/history/find?expression=TWAT>0"),
    get("/instruments"),
    put("/instruments/definitions/{name}", BOOST, "/instruments/definitions/boost"),
    delete("/instruments/definitions/{name}", "/instruments/definitions/boost"),
    post("/instruments", {"definition": "phone", "port": "position:"}),
    post("/instruments/position", {"latitude": 55.7, "longitude": 37.6}),
    delete("/instruments/{title}", "/instruments/phone"),
    get("/actions"),
    put("/actions", {"rules": [{"name": "ring", "when": "TWAT > 999", "sound": True}]}),
    post("/actions/try", {"name": "ring", "when": "TWAT > 0"}),
    post("/actions/{name}/perform", address="/actions/ring/perform"),
    put("/actions", {"rules": []}),
    get("/searches"),
    put("/searches", {"searches": []}),
)
UNIT = (
    get("/faults"),
    *change({"kind": "erase_faults"}),
    get("/freeze-frames"),
    get("/freeze-frames/{identity}", "/freeze-frames/none", status=404),
    delete("/freeze-frames/{identity}", "/freeze-frames/none", status=404),
    get("/passport"),
    post("/passport/probe"),
    get("/memory/{space}", "/memory/xram?address=0x9000&count=16"),
    post("/unlock", {}),
    *change({"kind": "write_memory", "space": "xram", "address": 0x9000, "data": "0102"}),
    get("/parameters/{name}", "/parameters/RCOD"),
    *change({"kind": "write_parameter", "name": "RCOD", "value": -0.25}),
    get("/co", takes={"co": lambda it: it["now"]["raw"]}),
    post(
        "/co/step",
        lambda kept: {"meter": "co", "target": 0.8, "found": kept.co, "figures": [2.0]},
    ),
    post("/lock"),
    get("/journal"),
    post("/dumps", {"space": "xram", "first": 0x8000, "last": 0x9FFF}, takes=IDENTITY),
    post("/dumps/{id}/pause", address=f"{DUMP}/pause"),
    get("/dumps/{id}", DUMP, until=dump_is("paused")),
    post("/dumps/{id}/resume", address=f"{DUMP}/resume"),
    post("/dumps/{id}/pause", address=f"{DUMP}/pause"),
    get("/dumps/{id}", DUMP, until=dump_is("paused")),
    *change(lambda kept: {"kind": "delete_dump", "id": kept.dump}),
    post("/dumps", {"space": "xram", "first": 0x8000, "last": 0x803F}, takes=IDENTITY),
    get("/dumps/{id}", DUMP, until=dump_is("done")),
    get("/dumps"),
    get("/dumps/{id}/file", f"{DUMP}/file"),
    post("/dumps/{id}/compare", bytes(64), f"{DUMP}/compare"),
)
TESTS = (
    get("/tests"),
    get("/state", until=samples),
    post("/tests/{name}/start", address="/tests/idle/start"),
    get("/tests/run"),
    post("/tests/run/skip"),
    post("/tests/run/cancel"),
    get("/tests/results"),
    put("/tests/results/{name}", {"in_report": True}, "/tests/results/none", status=404),
)
RECORDED = (
    post("/recording/start", {"name": "drive"}),
    get("/state", until=lambda it: it["recording"]["samples"] > 4),
    post("/recording/marker", {"label": "knock"}, takes={"time": lambda it: it["time"]}),
    put("/recording/marker", lambda kept: {"time": kept.time, "label": "pink"}),
    delete("/recording/marker", "/recording/marker?time={time}"),
    post("/recording/marker", {"label": "again"}),
    post("/recording/note", {"text": "uphill"}),
    post("/recording/stop"),
    get("/recordings", takes={"recording": lambda it: it["recordings"][0]["id"]}),
    get("/recordings/{identity}/file", f"{ONE}/file", takes={"bytes": lambda it: it}),
    post("/recordings", lambda kept: kept.bytes, "/recordings?name=other.pcapng"),
    post("/foreign-logs/preview", FOREIGN, "/foreign-logs/preview?name=a.csv"),
    post("/foreign-logs/values", FOREIGN, "/foreign-logs/values?name=a.csv&columns=1"),
    get("/recordings/{identity}", ONE, takes={"time": first_marker}),
    get("/recordings/{identity}/rows", f"{ONE}/rows?points=100"),
    put(
        "/recordings/{identity}/marker",
        lambda kept: {"time": kept.time, "label": "pink"},
        f"{ONE}/marker",
    ),
    delete("/recordings/{identity}/marker", f"{ONE}/marker?time={{time}}"),
    post(
        "/recordings/{identity}/markers",
        lambda kept: {"markers": [{"time": kept.time, "label": "ping"}]},
        f"{ONE}/markers",
    ),
    put("/recordings/{identity}/note", {"text": "downhill"}, f"{ONE}/note"),
    get("/recordings/{identity}/faults", f"{ONE}/faults"),
    get("/recordings/{identity}/tests/{name}", f"{ONE}/tests/idle"),
    get("/recordings/{identity}/causes", f"{ONE}/causes"),
    get("/recordings/{identity}/trip", f"{ONE}/trip"),
    get("/recordings/{identity}/trip/{form}", f"{ONE}/trip/geojson", status=400),
    get("/recordings/{identity}/pulls", f"{ONE}/pulls?mass=1600&per_1000=23"),
    get("/recordings/{identity}/find", f"{ONE}/find?expression=TWAT>0"),
    get("/channels/{name}/value", "/channels/TWAT/value?recording={recording}"),
    post("/channels/try", lambda kept: {"formula": "TWAT / 2", "recording": kept.recording}),
    *(
        get("/recordings/{identity}/export", f"{ONE}/export?format={form}&lang=ru")
        for form in ("csv", "msl", "mlg")
    ),
    *(
        get("/recordings/{identity}/export", f"{ONE}/export?format={form}", homes=("desktop",))
        for form in ("mf4", "parquet")
    ),
    get("/car"),
    put("/car", NAMED),
    put("/recordings/{identity}/car", NAMED, f"{ONE}/car"),
    get("/report", "/report?lang=ru"),
    get("/recordings/{identity}/report", f"{ONE}/report?lang=en"),
    get("/references"),
    put("/recordings/{identity}/reference", {"on": True}, f"{ONE}/reference"),
    *change(lambda kept: {"kind": "delete_recording", "id": kept.recording}),
)
VIRTUAL = tuple(
    row
    for identity in REFERENCES
    for row in (
        get("/recordings/{identity}", identity),
        get("/recordings/{identity}/rows", f"{identity}/rows?names=TWAT,FREQ&points=500"),
    )
)
SURVEY = (
    post("/survey/start", {"port": "sim:?scenario=survey", "engine": False}),
    get("/survey", until=lambda it: it["step"] is not None and it["step"]["place"] > 1),
    post("/survey/answer", {"id": 0}, status=409),
    post("/survey/stop"),
    get("/survey/result"),
    post("/survey/save"),
    get("/survey/file"),
    delete("/survey"),
)
END = (
    post("/doctor", {"port": CAR}),
    post("/doctor/stop"),
    post("/disconnect"),
    post("/control/release"),
)
ROUTES = (*BEGIN, *LIVE, *UNIT, *TESTS, *RECORDED, *VIRTUAL, *SURVEY, *END)
