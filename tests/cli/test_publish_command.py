"""`publish`: its options, errors and statuses, with a broker (amqtt) in this process."""

from __future__ import annotations

import json
import sys

import pytest
from cli_harness import is_one_short_paragraph, is_russian

from mikas.recording import CaptureReader
from publish.broker_rig import InProcessBroker, Listener, free_port, is_

pytestmark = pytest.mark.realtime
SECRET = "s3cret-WORD"


@pytest.fixture(scope="module")
def broker():
    broker = InProcessBroker()
    yield broker
    broker.close()


@pytest.fixture
def url(broker):
    return f"mqtt://127.0.0.1:{broker.port}"


def test_values_are_published_and_the_last_line_counts_them(mikas, broker, url):
    listener = Listener(broker.port)
    ran = mikas("publish", url, "TWAT", "FREQ", "--count", "20", "--each", "--topic", "a/b")
    listener.wait_for(is_("a/b/availability", b"offline"))
    listener.close()
    assert (ran.status, ran.out) == (0, "")
    first, *_, last = ran.err.splitlines()
    assert first == f"Publishing to {url} under a/b."
    assert last.startswith(f"{url}: ")
    assert "20 samples" in last
    by_topic = {it.topic: it for it in listener.got}
    assert by_topic["a/b/values"].json["values"]["TWAT"] > 0
    assert by_topic["a/b/value/FREQ"].json > 0
    assert by_topic["a/b/unit"].json["version_code"] == "0A"


def test_a_meter_beside_the_unit_is_published_with_it(mikas, broker, url):
    listener = Listener(broker.port)
    ran = mikas(
        "publish", url, "FREQ", "--count", "40", "--rate", "10", "--topic", "a/meter",
        "--instrument", "left:aem=sim:", "--every", "0.5",
    )  # fmt: skip
    listener.wait_for(is_("a/meter/availability", b"offline"))
    listener.close()
    assert ran.status == 0
    values = [it.json["values"] for it in listener.got if it.topic == "a/meter/values"]
    assert set(values[-1]) == {"FREQ", "LAMBDA_LEFT", "AFR_LEFT"}
    assert 0.5 < values[-1]["LAMBDA_LEFT"] < 2
    assert values[-1]["FREQ"] > 0
    wrong = mikas("publish", url, "FREQ", "--instrument", "ame=sim:")
    assert (wrong.status, "Did you mean aem" in wrong.err) == (2, True)


def test_all_notices_of_publish_are_in_russian(mikas, url):
    ran = mikas("publish", url, "TWAT", "--count", "3", "--lang", "ru")
    assert ran.status == 0
    is_russian(ran.err)


def test_json_has_a_line_for_each_change_and_the_end(mikas, url):
    ran = mikas("publish", url, "TWAT", "--count", "5", "--json")
    assert ran.status == 0
    lines = ran.objects
    assert all(line["schema"] == 1 for line in lines)
    assert [line["kind"] for line in lines] == ["broker", "line", "line", "end"]
    assert lines[0]["connected"] is True
    assert [line["state"] for line in lines[1:3]] == ["ecu-alive", "sampling"]
    assert (lines[-1]["samples"], lines[-1]["unsent"]) == (5, {"samples": 0, "events": 0})


def test_the_line_is_recorded_beside_it_with_the_faults(mikas, url, tmp_path):
    argv = ("publish", url, "TWAT", "--count", "5", "--capture", "a.pcapng")
    assert mikas(*argv, sim="&faults=13").status == 0
    kinds = [note.kind for note in CaptureReader(tmp_path / "a.pcapng").notes()]
    assert "faults-read" in kinds


def test_without_an_answer_the_command_ends_and_the_broker_knows(mikas, broker, url):
    listener = Listener(broker.port)
    ran = mikas("publish", url, "TWAT", "--topic", "silent", sim="&scenario=key-off&lost=1")
    listener.wait_for(is_("silent/state", state="stopped"))
    listener.wait_for(is_("silent/availability", b"offline"))
    listener.close()
    assert (ran.status, ran.out) == (3, "")


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ((), "mqtt://HOST"),
        (("localhost",), "mqtt://"),
        (("mqtt://h/topic",), "nothing follows"),
        (("mqtt://h", "NOSUCH"), "NOSUCH"),
        (("mqtt://h", "--topic", "a/#"), "wildcards"),
        (("mqtt://h", "--client-id", "\udcff"), "--client-id"),
        (("mqtt://h", "--home-assistant", "--discovery-prefix", "+"), "wildcards"),
        (("mqtt://h", "--qos", "3"), "from 0 to 2"),
        (("mqtt://h", "--every", "0"), "more than 0"),
        (("mqtt://h", "--tls-ca", "ca.pem"), "mqtts://"),
        (("mqtts://h", "--tls-ca", "none.pem"), "none.pem"),
        (("mqtt://h", "--password-file", "none.txt"), "none.txt"),
        (("mqtts://h", "--tls-cert", "a.pem"), "belong together"),
    ],
)
def test_wrong_usage_is_an_error_before_anybody_is_asked(mikas, words, says):
    ran = mikas("publish", *words)
    assert (ran.status, ran.out) == (2, "")
    assert says in ran.err
    is_one_short_paragraph(ran.err)
    is_russian(mikas("publish", *words, "--lang", "ru").err)


def test_no_broker_is_status_3_in_both_languages(mikas):
    nobody = f"mqtt://127.0.0.1:{free_port()}"
    ran = mikas("publish", nobody, "TWAT")
    assert (ran.status, ran.out) == (3, "")
    assert "nothing listens at this port there" in ran.err
    assert len(ran.err.strip().splitlines()) == 1
    is_russian(
        mikas("publish", nobody, "TWAT", "--lang", "ru").err, names=("Mosquitto", "listener")
    )
    error = mikas("publish", nobody, "TWAT", "--json").object["error"]
    assert error["code"] == "BrokerUnreachable"


def test_a_password_is_in_no_output(mikas, broker, monkeypatch):
    for words in (
        (f"mqtt://volga:{SECRET}@127.0.0.1:{free_port()}", "TWAT"),
        (f"mqtt://volga:{SECRET}@127.0.0.1:{broker.port}", "TWAT", "--count", "2"),
        (f"mqtt://volga:{SECRET}@127.0.0.1:1/x", "TWAT"),
        (f"tcp://volga:{SECRET}@127.0.0.1", "TWAT"),
    ):
        for more in ((), ("--json",), ("-vv",)):
            ran = mikas("publish", *words, *more)
            assert SECRET not in ran.out + ran.err
    monkeypatch.setenv("MIKAS_MQTT_PASSWORD", SECRET)
    ran = mikas("publish", "mqtt://127.0.0.1", "TWAT")  # a password, and no user
    assert (ran.status, SECRET in ran.err) == (2, False)


def test_a_missing_library_is_named_with_its_command(mikas, monkeypatch):
    monkeypatch.setitem(sys.modules, "aiomqtt", None)
    ran = mikas("publish", "mqtt://h", "TWAT")
    assert ran.status == 2
    assert 'pip install "mikas[mqtt]"' in ran.err


def test_what_is_kept_is_removed_without_a_unit(mikas, url, monkeypatch):
    monkeypatch.delenv("MIKAS_PORT")
    ran = mikas("publish", url, "--remove", "--json", "--discovery-prefix", "ha", "--topic", "a/b")
    assert ran.status == 0
    assert ran.object["removed"][0] == "ha/device/a--b/config"
    assert json.loads(ran.out)["removed"][-1] == "a/b/availability"
