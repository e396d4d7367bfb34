"""Rights by host, token and origin: every refusal."""

from __future__ import annotations

import re

import httpx
import pytest
from websockets.exceptions import InvalidStatus

from dashboard.rig import ME, rig
from mikas.dashboard.errors import Forbidden, TokenRequired
from mikas.dashboard.security.access import Access
from mikas.dashboard.security.middleware import MAX_BODY, MAX_LONG_BODY

LAN = {"lan": True, "hosts": ("10.1.2.3", "garage"), "token": "a-token-of-the-test"}
TOKEN = {"Authorization": f"Bearer {LAN['token']}"}


def scope(host, *, client="127.0.0.1", path="/", kind="http", query=b"", **headers):
    named = {"host": host, **{name.replace("_", "-"): value for name, value in headers.items()}}
    return {
        "type": kind,
        "path": path,
        "client": (client, 5555),
        "query_string": query,
        "headers": [(name.encode(), value.encode()) for name, value in named.items()],
    }


@pytest.mark.parametrize(
    "host", ["127.0.0.1:8071", "localhost:8071", "[::1]:8071", "LOCALHOST:8071"]
)
def test_this_computer_has_control(host):
    assert Access(8071).judge(scope(host)) == "control"
    assert Access(8071, **LAN).judge(scope(host)) == "control"


@pytest.mark.parametrize(
    "host",
    ["evil.example:8071", "127.0.0.1", "127.0.0.1:80", "", "localhost:8072", "10.1.2.3:8071",
     "127.0.0.1.evil.example:8071"],
)  # fmt: skip
def test_a_foreign_host_is_refused(host):
    with pytest.raises(Forbidden):
        Access(8071).judge(scope(host))


@pytest.mark.parametrize(
    "origin",
    ["http://evil.example", "null", "https://127.0.0.1:8071", "http://127.0.0.1:8072",
     "http://10.1.2.3:8071", "http://127.0.0.1:8071.evil.example", "file://"],
)  # fmt: skip
@pytest.mark.parametrize("kind", ["http", "websocket"])
def test_a_foreign_page_is_refused(origin, kind):
    with pytest.raises(Forbidden):
        Access(8071).judge(scope("127.0.0.1:8071", kind=kind, origin=origin))


def test_our_own_page_is_let_in():
    own = scope("localhost:8071", origin="http://localhost:8071", sec_fetch_site="same-origin")
    assert Access(8071).judge(own) == "control"


def test_a_foreign_page_that_hides_its_origin_is_refused():
    hidden = {"sec_fetch_site": "cross-site", "sec_fetch_mode": "no-cors"}
    with pytest.raises(Forbidden):
        Access(8071).judge(scope("127.0.0.1:8071", path="/api/state", **hidden))
    opened = {"sec_fetch_site": "cross-site", "sec_fetch_mode": "navigate"}
    with pytest.raises(Forbidden):
        Access(8071).judge(scope("127.0.0.1:8071", path="/api/memory/ram", **opened))
    assert Access(8071).judge(scope("127.0.0.1:8071", **opened))  # a link to us may be clicked


@pytest.mark.parametrize("client", ["10.1.2.9", "not an address", ""])
def test_from_the_network_the_token_is_wanted(client):
    access = Access(8071, **LAN)
    far = scope("10.1.2.3:8071", client=client)
    with pytest.raises(TokenRequired):
        access.judge(far)
    with pytest.raises(TokenRequired):  # a Host can be made up
        access.judge(scope("127.0.0.1:8071", client=client))
    with pytest.raises(TokenRequired):
        access.judge(scope("10.1.2.3:8071", client=client, authorization="Bearer wrong"))
    reported = scope("10.1.2.3:8071", client=client, authorization=TOKEN["Authorization"])
    assert access.judge(reported) == "view"
    assert Access(8071, lan_control=True, **LAN).judge(reported) == "control"


PROXIED = {
    "X-Forwarded-For": "127.0.0.1",
    "X-Forwarded-Host": "127.0.0.1",
    "X-Real-IP": "127.0.0.1",
    "Forwarded": "for=127.0.0.1",
    "Via": "1.1 a-proxy",
}


def test_no_header_names_the_sender_whatever_the_environment_says(tmp_path, monkeypatch):
    monkeypatch.setenv("FORWARDED_ALLOW_IPS", "*")
    monkeypatch.setenv("WEB_CONCURRENCY", "many")
    with rig(tmp_path, None, **LAN) as it:
        host = {"Host": f"127.0.0.1:{it.port}"}
        seen = []
        judge = Access.judge
        monkeypatch.setattr(
            Access, "judge", lambda *given: seen.append(given[1]["client"]) or judge(*given)
        )
        for name, value in PROXIED.items():
            forged = {**ME, **host, name: value}
            assert it.get("/state", 401, forged)["code"] == "TokenRequired", name
            assert it.post("/disconnect", None, 401, forged)["code"] == "TokenRequired", name
            assert it.get("/about", headers={**forged, **TOKEN})["rights"] == "view", name
        assert all(port for _, port in seen)  # 0: taken from a header
        assert it.get("/about", headers=host)["rights"] == "control"


def test_a_proxy_on_this_computer_gets_nothing_without_lan():
    for name, value in PROXIED.items():
        with pytest.raises(Forbidden, match="proxy"):
            Access(8071).judge(scope("127.0.0.1:8071", **{name.lower(): value}))


def test_the_token_may_come_as_a_cookie_and_to_a_socket_in_its_address():
    access = Access(8071, **LAN)
    assert access.judge(scope("garage:8071", cookie=f"a=b; mikas_8071={access.token}")) == "view"
    with pytest.raises(TokenRequired):
        access.judge(scope("garage:8071", cookie=f"mikas_8072={access.token}"))
    query = f"client=x&token={access.token}".encode()
    assert access.judge(scope("garage:8071", kind="websocket", query=query)) == "view"
    with pytest.raises(TokenRequired):  # in the address of a page it would be left lying about
        access.judge(scope("garage:8071", path="/api/state", query=query))


def test_the_link_becomes_a_cookie_and_leaves_the_address_bar(tmp_path):
    with rig(tmp_path, None, **LAN) as it:
        host = {"Host": f"10.1.2.3:{it.port}"}
        answer = it.client.get(f"/?token={LAN['token']}", headers=host)
        assert (answer.status_code, answer.headers["location"]) == (303, "/")
        cookie = answer.headers["set-cookie"]
        assert "HttpOnly" in cookie
        assert "SameSite=lax" in cookie
        with httpx.Client(base_url=it.client.base_url, verify=False) as fresh:
            refused = fresh.get("/", headers={**host, "Accept": "text/html"})
            assert refused.status_code == 401
            assert "QR" in refused.text
            kept = {**host, "Cookie": cookie.partition(";")[0]}
            assert fresh.get("/api/about", headers=kept).json()["rights"] == "view"
            assert fresh.get("/?token=wrong", headers=host).status_code == 401


def test_a_viewer_from_the_network_sees_everything_and_touches_nothing(tmp_path):
    with rig(tmp_path, "sim:?scenario=warm-idle", **LAN) as it:
        viewer = {**ME, **TOKEN, "Host": f"10.1.2.3:{it.port}"}
        it.sampling()
        about = it.get("/about", headers=viewer)
        assert (about["rights"], about["lan_url"]) == ("view", None)
        assert it.get("/about")["lan_url"] == f"http://10.1.2.3:{it.port}/?token={LAN['token']}"
        assert it.client.get("/api/about/qr.svg").headers["content-type"] == "image/svg+xml"
        assert it.client.get("/api/about/qr.svg", headers=viewer).status_code == 404
        own = it.dashboard.settings.in_state("instruments")
        own.mkdir(parents=True)
        (own / "mine.toml").write_text("decoder = 1\n")
        assert len(it.get("/instruments")["problems"]) == 1
        assert it.get("/instruments", headers=viewer)["problems"] == []
        assert it.get("/faults", headers=viewer)["count"] == 0  # as read when it was found
        for method, path in changing(it):
            answer = it.client.request(method, path, json=BODIES.get(path, {}), headers=viewer)
            assert answer.status_code == 403, (method, path, answer.text)
            assert answer.json()["error"]["code"] == "NotAllowed"
        url = {"Host": f"10.1.2.3:{it.port}"}
        with it.live(headers=TOKEN) as live:
            assert live.until(lambda m: m["state"])["state"]["rights"] == "control"  # loopback
        assert url


BODIES = {
    "/api/plan": {"wanted": [{"name": "FREQ"}]},
    "/api/control/take": {},
    "/api/dumps": {"space": "ram", "last": 1},
    "/api/changes": {"kind": "erase_faults"},
    "/api/network": {"on": True},
    "/api/presets": {"presets": []},
    "/api/searches": {"searches": []},
    "/api/recording/note": {"text": "x"},
}
LOOKING = {("POST", "/api/plan/price"), ("POST", "/api/dumps/{id}/compare")}


def changing(it):
    """Every route that is not GET, and those that make the line do something."""
    described = it.client.get("/api/openapi.json").json()["paths"]
    for path, methods in described.items():
        for method in methods:
            if method != "get" and (method.upper(), path) not in LOOKING:
                yield method.upper(), re.sub(r"\{\w+\}", "x", path)
    yield "GET", "/api/memory/ram?address=0"


@pytest.mark.parametrize(
    "headers",
    [{"Origin": "http://evil.example"}, {"Host": "evil.example:8071"}],
)
def test_a_foreign_socket_gets_403(shared_off, headers):
    with pytest.raises(InvalidStatus) as refused, shared_off.live(headers=headers):
        pass
    assert refused.value.response.status_code in (400, 403)  # two Hosts are not even HTTP
    assert shared_off.client.get("/api/state", headers=headers).status_code == 403


def test_a_socket_without_a_name_is_refused(shared_off):
    with pytest.raises(InvalidStatus) as refused, shared_off.live(client="x"):
        pass
    assert refused.value.response.status_code == 400


def test_every_answer_keeps_the_browser_in_its_place(shared_off):
    for path in ("/", "/api/state", "/api/docs", "/nowhere", "/api/nowhere"):
        headers = shared_off.client.get(path).headers
        assert headers["content-security-policy"].startswith("default-src 'self'")
        assert "unsafe" not in headers["content-security-policy"]
        assert headers["x-content-type-options"] == "nosniff"
        assert headers["x-frame-options"] == "DENY"
        assert headers["referrer-policy"] == "no-referrer"
        assert headers["cross-origin-resource-policy"] == "same-origin"
        assert headers["cross-origin-opener-policy"] == "same-origin"
        assert "access-control-allow-origin" not in headers
        assert "server" not in headers


@pytest.mark.parametrize(
    ("method", "path", "most"),
    [
        ("POST", "/connect", MAX_BODY),
        ("PUT", "/presets", MAX_LONG_BODY),
        ("POST", "/dumps/x/compare", MAX_LONG_BODY),
    ],
)
def test_a_body_without_end_is_refused(shared_off, method, path, most):
    def pieces():
        for _ in range(most // 65536 + 1):
            yield b"x" * 65536

    for content in (b"x" * (most + 1), pieces()):
        answer = shared_off.client.request(method, f"/api{path}", content=content, headers=ME)
        assert (answer.status_code, answer.json()["error"]["code"]) == (413, "TooLarge")
        assert f"{most // 1024} KiB" in answer.json()["error"]["en"]
    answer = shared_off.client.request(method, f"/api{path}", content=b"x" * most, headers=ME)
    assert answer.status_code in (400, 404, 405)


def test_a_wrong_path_method_or_value_gets_an_error_of_the_usual_shape(shared_off):
    error = shared_off.get("/nowhere", 404)
    assert error["code"] == "NotFound"
    assert error["ru"]
    assert shared_off.client.patch("/api/state").json()["error"]["code"] == "BadRequest"
    wrong = shared_off.post("/connect", {"echo": "perhaps"}, 400)
    assert "echo" in wrong["en"]


FAR = {"lan_control": True, **LAN}


@pytest.mark.parametrize(
    "url",
    ["replay:/etc/passwd", "replay:drive.pcapng", "socket://10.0.0.1:22", "socket:127.0.0.1:8071",
     "rfc2217://10.0.0.1:22", "/dev/ttyS99", "/dev/ttyUSB7?baud=9600", "serial:/dev/ttyUSB7",
     "sim:?scenario=/etc/passwd", "sim:?scenario=own.toml", "SIM:?scenario=own.toml",
     "sim:?clock=simulated", "sim:?latency_ms=900", "/etc/passwd"],
)  # fmt: skip
@pytest.mark.parametrize("path", ["/connect", "/doctor"])
def test_from_the_network_no_file_and_no_address_can_be_named(far, url, path):
    error = far.post(path, {"port": url}, 403, headers=from_far(far))
    assert error["code"] == "NotFromNetwork"
    assert url in error["ru"]
    assert far.get("/state")["line"] == "off"
    assert not far.cars.links


@pytest.mark.parametrize("url", ["socket://10.0.0.1:22", "gpsd:10.0.0.1:22", "/dev/ttyS99"])
def test_from_the_network_no_instrument_elsewhere_can_be_named(far, url):
    body = {"definition": "nmea", "port": url}
    assert far.post("/instruments", body, 403, headers=from_far(far))["code"] == "NotFromNetwork"
    assert far.get("/instruments")["instruments"] == []


@pytest.mark.parametrize("url", ["/dev/ttyUSB7", "sim:", "sim:?scenario=city&seed=2&faults=17",
                                 "sim:?scenario=city&car=leak:8"])  # fmt: skip
def test_from_the_network_an_adapter_or_a_virtual_car_may_be_chosen(far, url):
    assert far.post("/connect", {"port": url}, headers=from_far(far))["port"] == url
    far.post("/disconnect", headers=from_far(far))
    far.cars.links.clear()


def test_from_the_network_what_is_in_use_may_be_examined(tmp_path):
    with rig(tmp_path, None, **FAR) as it:
        it.post("/connect", {"port": "sim:?supplied=0"})
        it.post("/control/release")
        answer = it.client.post(
            "/api/doctor", json={"port": "sim:?supplied=0"}, headers=from_far(it)
        )
        assert answer.status_code == 200


def test_from_the_network_no_webhook_and_no_broker_can_be_named(tmp_path):
    with rig(tmp_path, None, **FAR) as it:
        ring = {"name": "ring", "when": "FREQ > 1", "sound": True}
        hook = {"name": "hook", "when": "FREQ > 1", "webhook": "http://127.0.0.1:9/"}
        secret = "mqtt://me:secret@garage"
        me = from_far(it)
        for wish in ({"rules": [hook]}, {"rules": [], "broker": "mqtt://garage"}):
            assert it.put("/actions", wish, 403, headers=me)["code"] == "OnlyHere"
        assert len(it.put("/actions", {"rules": [ring]}, headers=me)["rules"]) == 1
        it.post("/control/release", headers=me)
        here = it.put("/actions", {"rules": [ring, hook], "broker": secret})
        assert "secret" not in str(here)
        it.post("/control/release")
        kept = {"rules": here["rules"][::-1], "broker": here["broker"]}
        assert len(it.put("/actions", kept, headers=me)["rules"]) == 2
        assert it.dashboard.actions.loaded.broker == secret
        gone = {**kept, "rules": [ring]}
        assert it.put("/actions", gone, 403, headers=me)["code"] == "OnlyHere"


@pytest.fixture(scope="module")
def far(tmp_path_factory):
    with rig(tmp_path_factory.mktemp("far"), None, **FAR) as it:
        yield it


def from_far(it):
    return {**ME, **TOKEN, "Host": f"10.1.2.3:{it.port}"}
