"""`mikas wireshark`: printed, or put where Wireshark looks for it."""

from __future__ import annotations

import re

import pytest

from mikas.dissectors import installing
from mikas.dissectors.installing import plugin_file
from mikas.dissectors.wireshark.generator import MARK


@pytest.fixture(autouse=True)
def _on_any_system(monkeypatch, tmp_path):
    """Wireshark is neither there nor running, unless a test says so."""
    monkeypatch.setattr("shutil.which", lambda name: None)
    monkeypatch.setattr(installing, "_PROC", tmp_path / "none")
    monkeypatch.setattr(installing, "_printed", lambda *command: "")
    monkeypatch.setenv("APPDATA", str(tmp_path / "roaming"))


def test_the_dissector_is_printed_in_the_language(mikas):
    ran = mikas("wireshark")
    assert (ran.status, ran.err) == (0, "")
    assert ran.out.startswith(MARK)
    assert "Coolant temperature" in ran.out
    assert "Температура охлаждающей жидкости" in mikas("wireshark", "--lang", "ru").out


def test_a_redirected_stdout_of_another_encoding_gets_the_same_program(mikas, monkeypatch):
    whole = mikas("wireshark", "--lang", "ru").out
    monkeypatch.setattr("mikas.cli.render.terminal.is_utf8_out", lambda: False)
    printed = mikas("wireshark", "--lang", "ru").out
    assert printed.isascii()
    escaped = re.sub(rb"\\(\d{3})", lambda byte: bytes([int(byte[1])]), printed.encode())
    assert escaped == re.sub(rb"\\(\d{3})", lambda byte: bytes([int(byte[1])]), whole.encode())


def test_json_has_the_same_dissector(mikas):
    result = mikas("wireshark", "--json").object
    assert result["path"] is None
    assert result["text"] == mikas("wireshark").out


def test_installing_says_what_to_do_next(mikas):
    ran = mikas("wireshark", "--install")
    assert (ran.status, ran.out) == (0, "")
    assert str(plugin_file()) in ran.err
    assert "wireshark drive.pcapng" in ran.err
    assert "mikas.param.TWAT > 90" in ran.err
    assert plugin_file().read_text("utf-8") == mikas("wireshark").out
    again = mikas("wireshark", "--install", "--json")
    assert again.object == {"schema": 1, "path": str(plugin_file()), "written": False}
    assert "already" in again.err
    assert mikas("wireshark", "--install", "--lang", "ru", "--json").object["written"]


def test_the_users_own_catalog_is_in_it(mikas, tmp_path):
    own = tmp_path / "mine.toml"
    own.write_text(
        '[parameter.BOOST]\ncode = 0x33\nsize = 1\nunit = "kPa"\n'
        'text = { en = "Boost \\"x\\" pressure", ru = "Наддув" }\n',
        "utf-8",
    )
    mikas("--catalog", str(own), "wireshark", "--install")
    text = plugin_file().read_text("utf-8")
    assert '["name"] = "BOOST"' in text
    assert r'"Boost \"x\" pressure"' in text


def test_another_file_of_that_name_is_left(mikas):
    plugin_file().parent.mkdir(parents=True)
    plugin_file().write_text("-- mine\n", "utf-8")
    ran = mikas("wireshark", "--install")
    assert ran.status == 2
    assert "not written by mikas" in ran.err
    assert plugin_file().read_text("utf-8") == "-- mine\n"


def test_a_running_wireshark_is_told(mikas, monkeypatch):
    monkeypatch.setattr("shutil.which", lambda name: f"/usr/bin/{name}")
    monkeypatch.setattr(installing, "_printed", lambda *command: "wireshark\n")
    monkeypatch.setattr("sys.platform", "darwin")
    assert "is running" in mikas("wireshark", "--install").err
    assert "is running" not in mikas("wireshark", "--install").err


def test_a_missing_wireshark_is_told(mikas, monkeypatch):
    monkeypatch.setattr("sys.platform", "linux")
    assert "not found" in mikas("wireshark", "--install").err
