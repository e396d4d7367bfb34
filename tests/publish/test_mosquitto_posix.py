"""With the real broker: Mosquitto, and the program in a process of its own.

Skipped where there is no Mosquitto, unless `MIKAS_REQUIRE_MOSQUITTO` is set: then it is a failure.
"""

from __future__ import annotations

import gc
import os
import signal
import ssl
import subprocess
import sys
import threading
from pathlib import Path

import aiomqtt
import pytest
from broker_rig import MOSQUITTO, PATIENCE, Listener, Mosquitto, Relay, is_
from paho.mqtt import publish

from mikas.errors import BrokerNotTrusted, BrokerRefused, NoBroker
from mikas.publish import connection as module
from mikas.publish.broker import parse_address, with_tls
from mikas.publish.connection import BrokerChange, BrokerConnection
from mikas.publish.home_assistant import discovery_topic
from mikas.publish.outbox import Message, MessageKind, Outbox
from mikas.publish.session import Destination, remove
from mikas.publish.topics import Topics

pytestmark = [
    pytest.mark.realtime,
    pytest.mark.skipif(
        MOSQUITTO is None and not os.environ.get("MIKAS_REQUIRE_MOSQUITTO"),
        reason="mosquitto is not installed",
    ),
    pytest.mark.filterwarnings("ignore::ResourceWarning"),  # the fixture `connect` says why
]
SECRET = "s3cret-WORD"
BASE = "garage/volga"
# The command itself waits longer before it tries again, and for what the broker keeps.
PROGRAM = (
    "from mikas.publish import connection; connection._PAUSE = connection._KEPT = 0.1; "
    "from mikas.cli.main import main; main()"
)


@pytest.fixture
def start(tmp_path):
    """Start `mikas` in an environment of its own; whatever is left is ended."""
    environment = {
        "PATH": os.environ["PATH"], "HOME": str(tmp_path), "LANG": "C.UTF-8",
        "PYTHONPATH": os.environ.get("PYTHONPATH", ""),
    }  # fmt: skip
    running = []

    def started(*argv: str, **more: str) -> subprocess.Popen:
        process = subprocess.Popen(
            [sys.executable, "-c", PROGRAM, *argv],
            env=environment | more,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            encoding="utf-8",
        )
        running.append(process)
        return process

    yield started
    for process in running:
        process.kill()
        process.communicate()


@pytest.fixture
def broker(tmp_path):
    broker = Mosquitto(tmp_path)
    yield broker
    broker.close()


@pytest.fixture
def listen():
    """Make listeners; they end with the test."""
    made = []

    def listen(port: int, **settings: object) -> Listener:
        made.append(Listener(port, **settings))
        return made[-1]

    yield listen
    for each in made:
        each.close()


def publishing(
    start, port: int, *words: str, unit: str = "sim:", base: str = BASE
) -> subprocess.Popen:
    where = (f"mqtt://127.0.0.1:{port}", "--topic", base, "--port", unit)
    return start("publish", *where, "--method", "batch", *words)


def test_a_killed_publisher_is_offline_by_its_last_will(start, broker, listen):
    listener = listen(broker.port)
    process = publishing(start, broker.port, "TWAT", "--home-assistant", "--every", "0.2")
    values = listener.wait_for(is_(f"{BASE}/values", gap=False)).json
    assert values["values"]["TWAT"] > 0
    assert listener.got[-1].topic != f"{BASE}/availability"
    process.kill()
    will = listener.wait_for(is_(f"{BASE}/availability", b"offline"))
    assert not will.retain  # it came as it happened
    late = listen(broker.port)
    late.wait_for(is_(f"{BASE}/availability", b"offline"))
    kept = {it.topic for it in late.got if it.retain}
    assert kept <= {f"{BASE}/{name}" for name in
                    ("channels", "unit", "faults", "alarms", "state", "availability")} | {
        "homeassistant/device/garage--volga/config"}  # fmt: skip


def test_an_ended_publisher_says_so_itself(start, broker, listen):
    listener = listen(broker.port)
    ends = {"garage/volga": (signal.SIGTERM, 0), "garage/gazelle": (signal.SIGINT, 130)}
    running = {
        base: publishing(start, broker.port, "TWAT", "--every", "0.2", base=base) for base in ends
    }
    for base, (number, status) in ends.items():
        listener.wait_for(is_(f"{base}/values"))
        process = running[base]
        process.send_signal(number)
        out, err = process.communicate(timeout=PATIENCE)
        assert (process.returncode, out) == (status, ""), base
        assert "Traceback" not in err
        listener.wait_for(is_(f"{base}/availability", b"offline"))
        states = [it.json["state"] for it in listener.got if it.topic == f"{base}/state"]
        assert states[-1] == "stopped"
        assert "messages, " in err


def wait_until_recorded(file: Path, more: int) -> None:
    """Wait until the recording has so many more bytes."""
    waiting, wanted = threading.Event(), file.stat().st_size + more
    for _ in range(int(PATIENCE / 0.02)):
        if file.stat().st_size >= wanted:
            return
        waiting.wait(0.02)
    raise AssertionError(file.stat().st_size)


def test_broker_and_unit_may_be_lost_both_at_once(start, broker, listen, tmp_path):
    """Sampling and recording go on without the broker, samples are kept; the states are told when
    it is back.
    """
    relay, recorded = Relay(broker.port), tmp_path / "line.pcapng"
    before = listen(broker.port)
    try:
        unit = start("sim")
        process = publishing(
            *(start, relay.port, "TWAT", "--every", "0.2", "--samples", "--json"),
            *("--capture", str(recorded)),
            unit=unit.stdout.readline().strip(),
        )
        before.wait_for(is_(f"{BASE}/faults", current=True))  # what is read first
        relay.cut()
        broker.kill()
        for _ in range(2):  # lost, and soon later not there
            assert any('"connected": false' in line for line in process.stdout)
        wait_until_recorded(recorded, 1000)
        unit.kill()
        assert any('"state": "no-port"' in line for line in process.stdout)
        broker.start()
        after = listen(broker.port)
        relay.restore()
        state = after.wait_for(is_(f"{BASE}/state")).json
        assert state["state"] == "no-port"
        assert state["reason"]["ru"]
        values = after.wait_for(is_(f"{BASE}/values")).json
        assert (values["values"], values["gap"]) == ({"TWAT": None}, True)
        after.wait_for(is_(f"{BASE}/samples"))
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=PATIENCE)
        after.wait_for(is_(f"{BASE}/availability", b"offline"))
    finally:
        relay.close()
    rows = {}
    for got in (*before.got, *after.got):
        if got.topic == f"{BASE}/samples":
            batch = got.json
            rows |= enumerate(batch["samples"], batch["first"])
    assert sorted(rows) == list(range(len(rows)))  # none is missing over the outage
    times = [rows[number][0] for number in range(len(rows))]
    assert times == sorted(times)


def certificates(folder: Path, usage: str = "critical,keyCertSign,cRLSign") -> None:
    """Make a certificate authority, and of it the broker's certificate, for localhost alone.

    `usage`: what the authority's key is for, which Python demands from 3.13 on.
    """

    def run(*argv: str) -> None:
        subprocess.run(["openssl", *argv], cwd=folder, check=True, capture_output=True)

    new = ("-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2")
    run("req", "-x509", *new, "-keyout", "ca.key", "-out", "ca.pem", "-subj", "/CN=own authority",
        *(("-addext", f"keyUsage={usage}") if usage else ()))  # fmt: skip
    run("req", *new[:-2], "-keyout", "key.pem", "-out", "csr.pem", "-subj", "/CN=localhost")
    (folder / "names").write_text(
        "subjectAltName=DNS:localhost\nsubjectKeyIdentifier=hash\nauthorityKeyIdentifier=keyid\n",
        "utf-8",
    )
    run("x509", "-req", "-in", "csr.pem", "-CA", "ca.pem", "-CAkey", "ca.key", "-days", "2",
        "-extfile", "names", "-out", "cert.pem")  # fmt: skip


@pytest.fixture
def guarded(request, tmp_path):
    """A broker with TLS by an authority of its own, and with one user."""
    certificates(tmp_path, *getattr(request, "param", ()))
    passwords = tmp_path / "passwords"
    passwords.touch()
    subprocess.run(["mosquitto_passwd", "-b", passwords, "volga", SECRET], check=True)
    broker = Mosquitto(
        tmp_path,
        "allow_anonymous false",
        f"password_file {passwords}",
        f"certfile {tmp_path / 'cert.pem'}",
        f"keyfile {tmp_path / 'key.pem'}",
    )
    yield broker
    broker.close()


def test_tls_with_an_own_authority_and_a_password_that_is_never_shown(
    start, guarded, listen, tmp_path
):
    ca = tmp_path / "ca.pem"
    listener = listen(
        guarded.port, username="volga", password=SECRET, tls_insecure=True,
        tls_params=aiomqtt.TLSParameters(ca_certs=str(ca), cert_reqs=ssl.CERT_REQUIRED),
    )  # fmt: skip
    process = start(
        "publish", f"mqtts://localhost:{guarded.port}", "TWAT", "--topic", BASE, "--port", "sim:",
        "--tls-ca", str(ca), "--user", "volga", "--every", "0.2", "-vv", "--method", "batch",
        MIKAS_MQTT_PASSWORD=SECRET,
    )  # fmt: skip
    listener.wait_for(is_(f"{BASE}/values", gap=False))
    assert SECRET not in Path(f"/proc/{process.pid}/cmdline").read_text("utf-8")
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    assert f"mqtts://localhost:{guarded.port}" in err
    assert SECRET not in out + err
    assert not [it for it in listener.got if SECRET.encode() in it.payload]


@pytest.fixture
def connect(monkeypatch):
    """Make a connection in this process; it ends with the test."""
    monkeypatch.setattr(module, "_PAUSE", 0.02)
    made = []
    online, offline = (
        Message(f"{BASE}/availability", word, MessageKind.RETAINED)
        for word in (b"online", b"offline")
    )

    def connect(
        to: str, *, ca: Path | None = None, strict: bool = False, **settings: object
    ) -> BrokerConnection:
        broker = with_tls(parse_address(to), ca=ca)
        if strict:
            broker.tls.verify_flags |= ssl.VERIFY_X509_STRICT
        settings = {"client_id": "mikas", "online": online, "offline": offline} | settings
        made.append(BrokerConnection(broker, Outbox(), **settings))
        return made[-1]

    yield connect
    for each in made:
        each.close()
    made.clear()
    gc.collect()  # the library leaves the socket of a refused connection to the collector


def test_refusals_say_what_to_do(connect, guarded, tmp_path):
    ca = tmp_path / "ca.pem"
    for address, authority, kind, words in (
        (f"mqtts://volga:wrong-{SECRET}@localhost", ca, BrokerRefused, "not authorized"),
        ("mqtts://localhost", ca, BrokerRefused, "not authorized"),
        ("mqtts://volga@localhost", None, BrokerNotTrusted, "authority is unknown"),
        ("mqtts://volga@127.0.0.1", ca, BrokerNotTrusted, "another"),
    ):
        with pytest.raises(NoBroker) as caught:
            connect(f"{address}:{guarded.port}", ca=authority).open()
        assert isinstance(caught.value, kind), caught.value
        assert words in caught.value.text.en
        assert SECRET not in str(caught.value) + repr(caught.value.fields)
        del caught


@pytest.mark.parametrize("guarded", [("",)], ids=["no-key-usage"], indirect=True)
def test_an_own_authority_without_key_usage_is_refused_with_what_to_do(connect, guarded, tmp_path):
    """As Python does from 3.13 on; asked for here, so that each version shows it."""
    strict = connect(f"mqtts://localhost:{guarded.port}", ca=tmp_path / "ca.pem", strict=True)
    with pytest.raises(BrokerNotTrusted) as caught:
        strict.open()
    for words in (caught.value.text.en, caught.value.text.ru):
        assert "keyCertSign" in words
        assert "how-to/mqtt.md" in words
        assert "key usage" in words  # OpenSSL's own
    del caught


def test_what_the_broker_keeps_of_a_topic_is_read_before_the_first_message(connect, broker):
    url, kept, connected = f"mqtt://127.0.0.1:{broker.port}", [], []
    first = connect(url, client_id="other")
    first.open()
    first.send([Message("ha/config", b"1", MessageKind.RETAINED)])
    first.close()
    second = connect(url, kept_topic="ha/config", on_kept=lambda payload: kept.append(
        (payload, second.is_connected)), on_change=connected.append)  # fmt: skip
    second.open()
    assert kept == [(b"1", False)]
    assert [change.is_connected for change in connected] == [True]


def test_two_clients_of_one_name_are_told_so(connect, broker):
    """Each new one makes the broker close the other."""
    told = threading.Event()

    def on_change(change: BrokerChange) -> None:
        if change.error is not None and "same topic" in change.error.text.en:
            told.set()

    for _ in range(2):
        connect(f"mqtt://127.0.0.1:{broker.port}", on_change=on_change).open()
    assert told.wait(PATIENCE)


def test_all_that_is_kept_can_be_removed(start, broker, listen):
    some = ("TWAT", "--home-assistant", "--count", "5")
    process = publishing(start, broker.port, *some, unit="sim:?clock=simulated")
    assert process.wait(PATIENCE) == 0
    listen(broker.port).wait_for(is_(f"{BASE}/availability", b"offline"))
    topics = Topics(BASE)
    there = Destination(parse_address(f"mqtt://127.0.0.1:{broker.port}"), topics, "mikas")
    remove(there, discovery_topic("homeassistant", topics))
    late = listen(broker.port)
    first = connect_marker(broker.port)
    late.wait_for(is_(first))
    assert [it.topic for it in late.got if it.retain] == []


def connect_marker(port: int) -> str:
    """Publish a message behind all that is kept, and return its topic."""
    publish.single("marker", "x", qos=1, hostname="127.0.0.1", port=port)
    return "marker"
