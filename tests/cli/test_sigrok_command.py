"""`mikas sigrok`: where the decoder goes, what it replaces, what is said next."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest
from cli_harness import is_one_short_paragraph, is_russian

from mikas.catalog import shipped
from mikas.dissectors.installing import decoder_file
from mikas.dissectors.sigrok.generator import source


@pytest.fixture(autouse=True)
def no_folder(monkeypatch):
    for name in ("SIGROKDECODE_DIR", "XDG_DATA_HOME", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)


def test_without_an_option_it_is_printed(mikas):
    ran = mikas("sigrok")
    assert (ran.status, ran.err) == (0, "")
    assert ran.out == source(shipped())
    ran = mikas("sigrok", "--json", "--lang", "ru", "--interpretation", "literal")
    assert ran.object["path"] is None
    assert ran.object["text"] == source(
        shipped(), language="ru", interpretation="literal"
    )  # fmt: skip


def test_a_redirected_stdout_of_another_encoding_gets_the_same_program(mikas, monkeypatch):
    monkeypatch.setattr("mikas.cli.render.terminal.is_utf8_out", lambda: False)
    printed = mikas("sigrok", "--lang", "ru", "--checksum", "raw").out
    assert printed.isascii()
    whole = source(shipped(), language="ru", checksum="raw")
    assert ast.dump(ast.parse(printed)) == ast.dump(ast.parse(whole))


def test_it_is_installed_for_the_user_and_only_its_own_file_is_replaced(mikas):
    folder = mikas.home / ".local/share/libsigrokdecode/decoders/mikas"
    other = folder / "notes.txt"
    folder.mkdir(parents=True)
    other.write_text("mine", "utf-8")
    for argv in (("sigrok", "--install"), ("sigrok", "--install", "--lang", "ru")):
        ran = mikas(*argv)
        assert (ran.status, ran.out) == (0, "")
        assert str(folder / "__init__.py") in ran.err
        assert "baudrate=9600" in ran.err
    is_russian(ran.err, names=["sigrok-cli", "Mikas", "rate", "Debian", "sudo", "apt", "install"])
    assert (folder / "__init__.py").read_text("utf-8") == source(shipped(), language="ru")
    assert sorted(folder.iterdir()) == [folder / "__init__.py", other]
    found = mikas("sigrok", "--install", "--json", "--lang", "en").object
    assert (found["path"], found["written"]) == (str(folder / "__init__.py"), True)
    assert mikas("sigrok", "--install", "--json").object["written"] is False


def test_a_foreign_decoder_of_that_name_stays(mikas):
    foreign = Path("decoders/mikas/__init__.py")
    foreign.parent.mkdir(parents=True)
    foreign.write_text("from .pd import Decoder\n", "utf-8")
    ran = mikas("sigrok", "-o", "decoders")
    assert ran.status == 2
    is_one_short_paragraph(ran.err)
    assert foreign.read_text("utf-8") == "from .pd import Decoder\n"


def test_another_folder_is_named_in_the_advice(mikas):
    ran = mikas("sigrok", "-o", "new/decoders")
    assert ran.status == 0
    assert Path("new/decoders/mikas/__init__.py").is_file()
    assert f"SIGROKDECODE_DIR={Path('new/decoders').absolute()}" in ran.err


def test_what_cannot_be_written_is_one_sentence(mikas):
    Path("file").write_text("", "utf-8")
    ran = mikas("sigrok", "-o", "file")
    assert ran.status == 2
    is_one_short_paragraph(ran.err)
    assert mikas("sigrok", "-o", "file", "--json").object["error"]["code"] == "UsageError"
    assert mikas("sigrok", "--install", "-o", "decoders").status == 2


def test_the_own_catalog_is_in_it(mikas):
    Path("own.toml").write_text(
        '[parameter.BOOST]\ncode = 0x33\nsize = 1\ntext = { en = "Boost \\"x\\"", ru = "Наддув" }\n'
        'unit = "kPa"\n',
        "utf-8",
    )
    ran = mikas("sigrok", "--catalog", "own.toml")
    assert "'Boost \"x\"'" in ran.out
    assert "BOOST" not in mikas("sigrok").out


def test_the_folder_is_the_one_of_sigrok_on_each_system(monkeypatch, tmp_path):
    end = Path("libsigrokdecode/decoders/mikas/__init__.py")
    monkeypatch.setattr("pathlib.Path.home", lambda: tmp_path)
    for name in ("HOME", "USERPROFILE"):
        monkeypatch.setenv(name, str(tmp_path))
    for system in ("linux", "darwin"):
        monkeypatch.setattr("sys.platform", system)
        assert decoder_file() == tmp_path / ".local/share" / end
    monkeypatch.setattr("sys.platform", "win32")
    assert decoder_file() == tmp_path / "AppData/Local" / end
    monkeypatch.setenv("LOCALAPPDATA", str(tmp_path / "local"))
    assert decoder_file() == tmp_path / "local" / end
    monkeypatch.setattr("sys.platform", "linux")
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    assert decoder_file() == tmp_path / "data" / end
    monkeypatch.setenv("SIGROKDECODE_DIR", str(tmp_path / "own"))
    assert decoder_file() == tmp_path / "own/mikas/__init__.py"
