"""The dashboard says no password of its port, to no client and to no log."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from dashboard.rig import ADAPTER, ME
from mikas.dashboard.errors import InternalError
from mikas.dashboard.session.port_threads import Diagnosis
from mikas.dashboard.settings import PortSettings, Settings

PORT = "socket://me:zq0000001%2Bzq0000002@car:2000"
SHOWN = "socket://…@car:2000"


@pytest.fixture
def network(off):
    """The application with a port that has a password."""
    off.cars.ports[:] = [replace(ADAPTER, url=PORT)]
    off.post("/connect", {"port": PORT})
    off.sampling()
    return off


def test_no_answer_about_the_port_has_its_password(network) -> None:
    assert network.get("/state")["port"] == SHOWN
    assert network.get("/passport")["port"] == SHOWN
    for path in ("/state", "/passport", "/history", "/report"):
        shown = network.get(path)
        assert "zq" not in (json.dumps(shown) if isinstance(shown, dict) else shown.text)
    with network.live() as live:
        live.until(lambda it: it["state"])
        assert "zq" not in json.dumps(live.state)


def test_no_answer_about_an_instrument_has_the_password_of_its_port(network) -> None:
    other = PORT.replace("car", "meter")
    meter = {"definition": "aem", "port": other}
    network.post("/instruments", meter)
    refused = network.post("/instruments", meter | {"port": f"{other}1"}, status=400)
    shown = [refused, network.get("/instruments"), network.get("/state")]
    with network.live() as live:
        shown.append(live.until(lambda it: it["state"]["instruments"][0]["state"] == "lost"))
    assert "zq" not in json.dumps(shown)
    assert network.get("/instruments")["instruments"][0]["port"] == SHOWN.replace("car", "meter")


def test_the_port_in_use_is_named_by_what_is_shown_of_it(network) -> None:
    assert network.post("/connect", {"port": SHOWN})["port"] == SHOWN
    network.sampling()
    assert [link.url for link in network.cars.links] == [PORT, PORT]
    shown = network.client.post("/api/doctor", json={"port": SHOWN}, headers=ME).text
    assert SHOWN in shown
    assert "zq" not in shown
    assert network.cars.links[-1].url == PORT


def test_a_bug_at_the_port_is_shown_without_its_password(tmp_path, caplog) -> None:
    def fail(url):
        raise RuntimeError(f"odd: {url}, zq0000001+ZQ0000002")

    diagnosis = Diagnosis(PortSettings(PORT), Settings(tmp_path, state=tmp_path, open_port=fail))
    with pytest.raises(InternalError, match="RuntimeError: odd") as failed:
        diagnosis.run(lambda _: None)
    assert "RuntimeError: odd" in caplog.text
    assert "zq" not in (caplog.text + str(failed.value)).lower()
