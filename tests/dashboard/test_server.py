"""The page, the description of the API, the socket, the command line."""

from __future__ import annotations

import asyncio
import socket
from datetime import UTC, datetime

import pytest
import uvicorn
from fastapi import FastAPI

from dashboard.rig import rig
from mikas.cli.commands.dash import show_dashboard
from mikas.cli.context import CommandContext
from mikas.cli.options.dashboard import DashboardOptions
from mikas.dashboard.network.addresses import own_addresses
from mikas.dashboard.network.listening import FIRST_PORT, listen
from mikas.dashboard.page import shape
from mikas.dashboard.security.certificate import own_certificate
from mikas.dashboard.server import Server
from mikas.dashboard.settings import VirtualCars
from mikas.errors import BadPortUrl, UsageError
from mikas.link import open_link


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    tmp_path = tmp_path_factory.mktemp("page")
    folder = tmp_path / "built"
    (folder / "assets").mkdir(parents=True)
    (folder / "index.html").write_text("<!doctype html>the page", "utf-8")
    (folder / "icon.svg").write_text("<svg/>", "utf-8")
    (folder / "assets" / "main-abc.js").write_text("1", "utf-8")
    (tmp_path / "secret.txt").write_text("the treasure", "utf-8")
    with rig(tmp_path, None, page=folder) as it:
        yield it


def test_the_page_is_not_cached_and_its_parts_are(built):
    page = built.client.get("/")
    assert page.text == "<!doctype html>the page"
    assert page.headers["cache-control"] == "no-cache"
    part = built.client.get("/assets/main-abc.js")
    assert part.headers["cache-control"] == "public, max-age=31536000, immutable"
    assert part.headers["content-type"].startswith("text/javascript")
    again = built.client.get("/", headers={"If-None-Match": page.headers["etag"]})
    assert (again.status_code, again.text) == (200, page.text)  # it is small, and always whole
    assert built.client.get("/icon.svg").headers["content-type"] == "image/svg+xml"


@pytest.mark.parametrize(
    "path",
    ["/../secret.txt", "/..%2fsecret.txt", "/assets/../../secret.txt", "/%2e%2e/secret.txt",
     "/assets", "/nothing.js", "/%00"],
)  # fmt: skip
def test_nothing_else_is_served(built, path):
    answer = built.client.get(path)
    assert answer.status_code == 404
    assert "treasure" not in answer.text


def test_a_page_that_was_not_built_says_so_in_words(shared_off):
    page = shared_off.client.get("/")
    assert page.status_code == 200
    assert "pip install" in page.text
    assert "собранной" in page.text


def test_the_api_describes_itself_without_any_network(shared_off):
    page = shared_off.client.get("/api/docs")
    assert page.headers["content-type"].startswith("text/html")
    assert "<script" not in page.text
    assert "//cdn" not in page.text
    for path in shared_off.client.get("/api/openapi.json").json()["paths"]:
        assert path in page.text
    assert "text/css" in shared_off.client.get("/api/docs/style.css").headers["content-type"]


def test_every_route_says_what_it_takes_gives_and_refuses(shared_off):
    described = shared_off.client.get("/api/openapi.json").json()
    for path, methods in described["paths"].items():
        for method, route in methods.items():
            operation = f"{method} {path}"
            assert route["description"] or route["summary"], operation
            assert {"400", "401", "403"} <= set(route["responses"]), operation
            good = route["responses"].get("200") or route["responses"]["204"]
            assert "content" in good or "204" in route["responses"], operation
            for status, answer in route["responses"].items():
                if status >= "400":
                    schema = answer["content"]["application/json"]["schema"]
                    assert schema == {"$ref": "#/components/schemas/ErrorResponse"}, operation
            if method in ("post", "put"):
                json = good["content"].get("application/json", {"schema": {"$ref": ""}})
                assert "$ref" in json["schema"], operation


def test_shapes_are_named_in_a_word_or_two():
    assert shape({"anyOf": [{"type": "string"}, {"type": "null"}]}) == "string or null"
    assert shape({"type": "array", "items": {"$ref": "#/x/Y"}}) == "list of Y"
    assert shape({"enum": ["a", 1]}) == '"a" | 1'
    assert shape({"const": True}) == "true"
    assert shape({"type": "object", "additionalProperties": {"type": "number"}}) == "name → number"
    assert shape({}) == "anything"


def test_a_taken_port_leads_to_the_next_one():
    with listen(None, lan=False) as first:
        assert first.getsockname()[0] == "127.0.0.1"
        with listen(None, lan=False) as second:
            assert second.getsockname()[1] != first.getsockname()[1]
        taken = first.getsockname()[1]
        with pytest.raises(UsageError, match=str(taken)):
            listen(taken, lan=False)
    assert taken >= FIRST_PORT


def test_the_network_sees_us_only_when_that_is_wanted():
    with listen(0, lan=True) as own:
        assert own.getsockname()[0] == "0.0.0.0"
    names = own_addresses()
    assert socket.gethostname() in names
    assert not any(name.startswith("127.") for name in names)


def test_a_computer_s_name_that_no_dns_can_have_is_only_shown(monkeypatch):
    monkeypatch.setattr("socket.gethostname", lambda: "a" * 64)
    assert own_addresses()[-2:] == ("a" * 64, f"{'a' * 64}.local")


def test_a_virtual_car_outlives_its_connection():
    cars = VirtualCars()
    first = cars.open("sim:?seed=3")
    first.close()
    second = cars.open("sim:?seed=3")
    assert second.bus is first.bus
    assert second.now() > 1e9
    second.write(b"")
    assert cars.open("sim:?seed=4").bus is not first.bus
    simulated = "sim:?clock=simulated"
    assert cars.open(simulated).bus is not cars.open(simulated).bus


@pytest.fixture
def served(monkeypatch, tmp_path):
    """What the command line starts, instead of serving it."""
    started = []

    def serve(app, own, *, ready, tls):
        started.append((app, own[0].getsockname(), tls))
        ready()

    monkeypatch.setattr("mikas.dashboard.server.serve", serve)
    return started


def test_the_address_comes_first_and_the_browser_is_opened(served, monkeypatch, capsys, tmp_path):
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    monkeypatch.setattr("threading.Thread.start", lambda thread: thread.run())
    show_dashboard(CommandContext(), DashboardOptions(record=tmp_path))
    url = capsys.readouterr().out.splitlines()[0]
    assert opened == [url]
    assert url == f"http://127.0.0.1:{served[0][1][1]}/"


@pytest.fixture
def state(monkeypatch, tmp_path):
    """The folder of the certificate."""
    monkeypatch.setenv("MIKAS_STATE", str(tmp_path / "state"))
    return tmp_path / "state"


def test_the_link_for_others_comes_with_a_picture_and_a_fingerprint(
    served, state, capsys, tmp_path
):
    options = DashboardOptions(lan=True, no_browser=True, record=tmp_path)
    show_dashboard(CommandContext(), options)
    reported = capsys.readouterr()
    link = reported.out.splitlines()[1]
    assert link.startswith("https://")
    assert "?token=" in link
    assert "█" in reported.err or "▄" in reported.err
    app, _, tls = served[0]
    access = app.state.access
    assert access.lan
    assert not access.lan_control
    pairs = reported.err.splitlines()[-2:]
    assert ":".join(line.strip() for line in pairs) == access.fingerprint
    assert link.endswith(f"#sha256={pairs[0].strip()[:23]}")
    assert all(len(line) < 80 for line in pairs)
    assert tls.get_ciphers()
    show_dashboard(CommandContext(), options)
    assert served[1][0].state.access.fingerprint == access.fingerprint  # a phone knows it already


def test_a_certificate_of_one_s_own_names_the_link(served, state, capsys, tmp_path):
    file = tmp_path / "own.pem"
    own_certificate(file, ("mikas.example",), datetime.now(UTC))
    options = {"lan": True, "no_browser": True, "record": tmp_path}
    show_dashboard(CommandContext(), DashboardOptions(tls_cert=file, tls_key=file, **options))
    assert capsys.readouterr().out.splitlines()[1].startswith("https://mikas.example:")
    assert not state.exists()


def test_without_encryption_there_is_a_warning(served, state, capsys, tmp_path):
    options = {"lan": True, "no_browser": True, "record": tmp_path}
    show_dashboard(CommandContext(), DashboardOptions(no_tls=True, **options))
    reported = capsys.readouterr()
    assert reported.out.splitlines()[1].startswith("http://")
    assert "Whoever is in this network can read the key" in reported.err
    app, _, tls = served[0]
    assert tls is None
    assert app.state.access.fingerprint is None
    assert not state.exists()


def test_what_makes_no_sense_is_refused_before_anything_is_opened(served, tmp_path):
    run = CommandContext(port="nonsense://x")
    with pytest.raises(BadPortUrl):
        show_dashboard(run, DashboardOptions())
    run.port, run.capture = None, tmp_path / "x.pcapng"
    with pytest.raises(UsageError, match="record"):
        show_dashboard(run, DashboardOptions())
    (tmp_path / "file").touch()
    options = {"host_port": None, "lan": False, "no_browser": True}
    with pytest.raises(UsageError):
        DashboardOptions(**options, lan_control=False, record=tmp_path / "file")
    assert DashboardOptions(**options, lan_control=True, record=None).lan
    file = tmp_path / "file"
    for tls in (
        {"no_tls": True},
        {"tls_cert": file, "tls_key": file},
        {"lan": True, "tls_cert": file},
        {"lan": True, "tls_key": file},
        {"lan": True, "tls_cert": file, "tls_key": file, "no_tls": True},
    ):
        with pytest.raises(UsageError, match="tls"):
            DashboardOptions(**tls)
    assert not served


def test_the_cars_of_the_demo_are_those_of_the_command_line():
    assert type(open_link("sim:")) is type(VirtualCars().open("sim:"))


class Made(Exception):
    """The protocol that uvicorn makes of a connection."""


async def both_protocols():
    """uvicorn's, and that of `Server._protocol` for the same server."""

    def create_server(create, **_):
        raise Made(create())

    asyncio.get_running_loop().create_server = create_server
    plain = uvicorn.Server(uvicorn.Config(FastAPI(), http="h11", lifespan="off", log_config=None))
    with socket.socket() as own, pytest.raises(Made) as made:
        await plain.serve(sockets=[own])
    return made.value.args[0], Server._protocol(plain)  # noqa: SLF001


def test_uvicorn_makes_a_connection_s_protocol_as_the_server_does():
    # uvicorn does not document this call, so pyproject.toml caps its version.
    try:
        theirs, ours = asyncio.run(both_protocols())
        assert type(ours) is type(theirs)
        for given in ("config", "server_state", "app_state"):
            assert getattr(ours, given) is getattr(theirs, given)
    except (AttributeError, TypeError) as error:
        pytest.fail(
            f"uvicorn {uvicorn.__version__} makes the protocol of a connection otherwise than "
            f"Server._protocol in mikas.dashboard.server: {error}. Compare it with startup of "
            "uvicorn.Server, then raise the cap in pyproject.toml"
        )
