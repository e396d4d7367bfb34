"""`connect`: settings, bad settings, and a port that is let go of when it fails."""

from __future__ import annotations

import pytest
from client_harness import bench

from link_rig import registered
from mikas import errors
from mikas.catalog import shipped
from mikas.client import connect
from mikas.client.connecting import ConnectionOptions
from mikas.client.limits import STARTING_LIST
from mikas.link import Direction, open_link
from mikas.link.virtual import VirtualLink
from mikas.virtual.build import build_bus

SIM = "sim:?clock=simulated"


@pytest.fixture
def links():
    """Every link opened as `bench:`, on units queued in `links.units`."""

    class Links(list):
        def __init__(self):
            super().__init__()
            self.units = []

    opened = Links()

    def opener(url, options):
        link = VirtualLink(opened.units.pop(0).bus, url=url)
        opened.append(link)
        return link

    with registered("bench", opener):
        yield opened


def closed(link):
    try:
        link.read(link.now())
    except errors.LinkLost:
        return True
    return False


def test_a_link_of_ones_own_is_taken_and_closed_with_the_unit():
    class Duck:
        """Has the methods of a link and is none by its class."""

        def __init__(self, link):
            self._link = link

        def __getattr__(self, name):
            return getattr(self._link, name)

    for made in (lambda link: link, Duck):
        link = open_link(SIM)
        with connect(link=made(link)) as ecu:
            assert ecu.read("TWAT")["TWAT"].unit == "°C"
        assert closed(link)
    link = open_link(SIM + "&scenario=key-off&lost=1")
    with pytest.raises(errors.EchoOnly):
        connect(link=link, retries=0)
    assert closed(link)
    with pytest.raises(errors.UsageError, match="not both"):
        connect(SIM, link=link)


def test_the_port_is_that_of_the_environment_then_of_the_config_file(tmp_path, monkeypatch):
    config = tmp_path / "config.toml"
    config.write_text('port = "sim:?clock=simulated&model=5.4"\n')
    monkeypatch.setenv("MIKAS_CONFIG", str(config))
    monkeypatch.delenv("MIKAS_PORT", raising=False)
    with connect() as ecu:
        assert ecu.version_code == 0x09
    monkeypatch.setenv("MIKAS_PORT", SIM)
    with connect() as ecu:
        assert ecu.version_code == 0x0A
    config.write_text("port = \n")
    monkeypatch.delenv("MIKAS_PORT")
    with pytest.raises(errors.UsageError, match="config file"):
        connect()
    for wrong in ("5", '["sim:"]', "true"):
        config.write_text(f"port = {wrong}\n")
        with pytest.raises(
            errors.UsageError, match=r"config\.toml: port has to be a port in quotes"
        ):
            connect()


def test_the_unit_is_found_and_ready():
    with connect(SIM) as ecu:
        assert (ecu.version_code, ecu.model.known) == (0x0A, True)
        assert ecu.read("TWAT")["TWAT"].unit == "°C"
    with pytest.raises(errors.LinkLost):
        ecu.read("TWAT")
    ecu.close()


@pytest.mark.parametrize(
    ("setting", "value", "allowed"),
    [
        ("echo", "maybe", "auto, on, off"),
        ("echo", True, "auto, on, off"),
        ("interpretation", "both", "corrected, literal, alternative, family"),
        ("timeout", -1, "from 0.001"),
        ("timeout", 0, "from 0.001"),
        ("timeout", float("nan"), "from 0.001"),
        ("timeout", float("inf"), "from 0.001"),
        ("timeout", "0.5", "from 0.001"),
        ("timeout", None, "from 0.001"),
        ("inter_byte_timeout", 0.0, "from 0.001"),
        ("retries", -1, "from 0"),
        ("retries", 1.5, "whole"),
        ("retries", True, "from 0"),
    ],
)
def test_a_bad_setting_is_named_with_what_is_allowed(links, setting, value, allowed):
    with pytest.raises(errors.UsageError) as caught:
        connect("bench:", **{setting: value})
    assert setting in str(caught.value)
    assert str(value) in caught.value.text.ru
    assert allowed in str(caught.value)
    assert links == []  # no port was opened for it


def test_an_own_catalog_that_is_wrong_opens_no_port(links, tmp_path):
    own = tmp_path / "own.toml"
    own.write_text("[parameter.X]\n")
    with pytest.raises(errors.CatalogError):
        connect("bench:", catalogs=[own])
    assert links == []


def test_an_own_catalog_is_used(links, tmp_path):
    own = tmp_path / "own.toml"
    own.write_text(
        '[parameter.BOOST]\ncode = 0x1A\nsize = 1\nunit = "kPa"\ntext = { en = "b", ru = "b" }\n'
    )
    links.units.append(bench())
    with connect("bench:", catalogs=[own]) as ecu:
        assert ecu.read("BOOST")["BOOST"].unit == "kPa"


def test_the_port_is_closed_when_no_ecu_answers(links):
    silent = bench()
    silent.car.on = False
    links.units.append(silent)
    with pytest.raises(errors.EchoOnly):
        connect("bench:", retries=0)
    assert closed(links[0])


def test_the_port_is_let_go_of_when_interrupted(links, monkeypatch):
    def stop(self):
        raise KeyboardInterrupt

    links.units.append(bench())
    monkeypatch.setattr("mikas.tester.Tester.connect", stop)
    with pytest.raises(KeyboardInterrupt):
        connect("bench:")
    assert closed(links[0])


def test_without_a_port_the_error_says_that_there_is_none(monkeypatch):
    monkeypatch.setattr("mikas.link.ports.find_ports", lambda _: [])
    with pytest.raises(errors.NoPortGiven) as caught:
        connect()
    assert "none" in str(caught.value)
    with pytest.raises(errors.PortNotFound):
        connect(None)
    with pytest.raises(errors.BadPortUrl):
        connect("")


def test_bad_urls_are_usage_errors():
    for url in ("sim:?clock=late", "sim:?nonsense=1", "simm://", "sim:?scenario=moon"):
        with pytest.raises(errors.UsageError):
            connect(url)


def test_timing_settings_reach_the_tester():
    with connect(SIM, timeout=0.25, inter_byte_timeout=0.05, retries=5) as ecu:
        assert ecu.tester.line.timing.response_timeout == 0.25
        assert ecu.tester.line.timing.inter_byte_timeout == 0.05
        assert ecu.tester.retries == 5


def test_echo_off_finds_a_unit_behind_an_adapter_that_keeps_it():
    with connect(SIM + "&echo=0", echo="off") as ecu:
        assert not ecu.tester.line.echo
    with connect(SIM + "&echo=0") as ecu:
        assert not ecu.tester.line.echo
        assert ecu.info().echo is False


def test_what_passes_on_the_wire_goes_to_the_sink():
    observed = []

    class Sink:
        def record(self, direction, data, time):
            observed.append((direction, data))

    with connect(SIM, sink=Sink()) as ecu:
        ecu.read("TWAT")
    sent = b"".join(data for direction, data in observed if direction is Direction.SENT)
    assert b"\x61\x1a\x85\x0d" in sent
    assert any(direction is Direction.RECEIVED for direction, _ in observed)


def test_journal_and_state_may_be_given_as_texts(tmp_path):
    journal = tmp_path / "deep" / "journal.jsonl"
    with connect(SIM, journal=str(journal), state=str(tmp_path / "units")) as ecu:
        ecu.set_list("TWAT")
    assert journal.exists()


def test_without_a_journal_named_the_users_own_is_taken(state_folder):
    with connect(SIM) as ecu:
        ecu.set_list("TWAT")
    assert (state_folder / "journal.jsonl").exists()


class Wired(VirtualLink):
    """A virtual unit behind a pty or TCP: only its passport tells."""

    is_virtual = False


class TestLearntLimitsOfVirtualUnits:
    """A wrong limit costs a session; a virtual unit has others each time."""

    @pytest.fixture
    def users_own(self, monkeypatch, tmp_path):
        monkeypatch.delenv("MIKAS_STATE")
        monkeypatch.setattr("mikas.home.state_folder", lambda: tmp_path / "mikas")
        return tmp_path / "mikas"

    @staticmethod
    def learn():
        with connect(f"{SIM}&max_list=5") as ecu:
            ecu.read()
            return ecu.limits().max_list

    @staticmethod
    def remembered(url=SIM):
        with connect(url) as ecu:
            return ecu.limits().max_list

    def test_limits_of_a_virtual_unit_are_not_kept(self, users_own):
        assert self.learn() == 5
        assert not users_own.exists()

    def test_kept_limits_are_not_used_for_a_virtual_unit(self, users_own, monkeypatch):
        monkeypatch.setenv("MIKAS_STATE", str(users_own))
        assert self.learn() == 5
        assert self.remembered() == 5  # asked for
        monkeypatch.delenv("MIKAS_STATE")
        assert self.remembered() == STARTING_LIST

    def test_a_virtual_unit_on_a_wire_is_known_by_its_passport(self, users_own):
        def opener(url, options):
            return Wired(build_bus(options), url=url)

        with registered("wired", opener), connect("wired:?max_list=5") as ecu:
            ecu.read()
            assert ecu.limits().max_list == 5
            ecu.keep_timings("adapter", {})
        assert not users_own.exists()

    def test_limits_of_a_car_are_kept(self, users_own, links):
        links.units += [bench(max_list=5), bench()]
        options = ConnectionOptions()
        for _ in range(2):
            ecu = options.create_ecu(Wired(links.units.pop(0).bus))
            ecu.tester.connect()
            ecu.read()
            assert ecu.limits().max_list == 5
        assert list(users_own.glob("units/*.json"))


class TestConnectionOptions:
    """`create_ecu` on any link, for links that come and go."""

    def test_an_ecu_is_created_not_yet_connected(self, tmp_path):
        options = ConnectionOptions(
            state=tmp_path / "units", journal=tmp_path / "journal", interpretation="literal"
        )
        for _ in range(2):
            link = open_link(SIM)
            with options.create_ecu(link) as ecu:
                assert ecu.tester.link is link
                assert ecu.tester.version_code is None
                ecu.tester.connect()
                assert ecu.read("FREQ")["FREQ"].interpretation == "literal"

    def test_definitions_that_are_loaded_already(self):
        catalog = shipped()
        assert ConnectionOptions(catalog=catalog).create_ecu(open_link(SIM)).catalog is catalog

    @pytest.mark.parametrize(
        "settings",
        [{"echo": "loud"}, {"interpretation": "wrong"}, {"timeout": 0}, {"retries": 1.5}],
    )
    def test_settings_are_checked_before_there_is_a_link(self, settings):
        with pytest.raises(errors.UsageError):
            ConnectionOptions(**settings)
