"""Memory on the command line: dumps with their manifests, comparing, writing and its journal."""

from __future__ import annotations

import json
from hashlib import sha256

import pytest
from cli_harness import SIM, is_one_short_paragraph, is_russian

from mikas.errors import LinkLost


def test_read_is_a_hex_dump(mikas):
    (line,) = mikas("mem", "read", "ram", "40", "16").lines
    assert line.startswith("0040  45 6A 8F")
    assert mikas("mem", "read", "RAM", "0x40", "0x10").lines == [line]
    assert len(mikas("mem", "read", "ram", "3Fh", "2").lines) == 2


def test_dump_writes_the_memory_and_a_manifest_that_describes_it(mikas, tmp_path):
    ran = mikas("mem", "dump", "ram", "-o", "ram.bin", "--verify")
    data = (tmp_path / "ram.bin").read_bytes()
    manifest = json.loads((tmp_path / "ram.bin.json").read_text("utf-8"))
    assert ran.status == 0
    assert sha256(data).hexdigest() in ran.out
    assert len(data) == 256
    assert manifest["sha256"] == sha256(data).hexdigest()
    assert (manifest["space"], manifest["first"], manifest["last"]) == ("ram", 0, 255)
    assert (manifest["complete"], manifest["verified"], manifest["schema"]) == (True, True, 1)
    assert manifest["model"] == "Mikas 7.1"
    assert manifest["passport"][0] == "МИКАС 7.1"
    assert (tmp_path / "ram.bin.json").read_text("utf-8").endswith("}\n")


@pytest.mark.parametrize("block", [[], ["--block", "1"], ["--block", "7"], ["--block", "0x20"]])
def test_a_part_of_a_memory_is_dumped(mikas, tmp_path, block):
    assert (
        mikas("mem", "dump", "xram", "-o", "x", "--from", "1000", "--to", "103F", *block).status
        == 0
    )
    shown = mikas("mem", "read", "xram", "1000", "64", "--json").object["data"]
    assert (tmp_path / "x").read_bytes().hex().upper() == shown


def test_a_file_that_is_there_is_not_touched(mikas, tmp_path):
    (tmp_path / "x").write_bytes(b"precious")
    ran = mikas("mem", "dump", "ram", "-o", "x")
    assert ran.status == 2
    assert "--resume" in ran.err
    assert (tmp_path / "x").read_bytes() == b"precious"
    assert mikas("mem", "dump", "ram", "-o", "x", "--resume").status == 2  # it has no manifest
    assert (tmp_path / "x").read_bytes() == b"precious"


@pytest.fixture
def cut(mikas, monkeypatch, tmp_path):
    """A dump whose adapter was pulled out after 100 bytes."""
    from mikas.client.memory.spaces import MemorySpace

    blocks = MemorySpace.blocks

    def some(self, address, count, largest=None):
        for number, data in enumerate(blocks(self, address, count, 10)):
            if number == 10:
                raise LinkLost(url="sim:", problem="pulled out")
            yield data

    monkeypatch.setattr(MemorySpace, "blocks", some)
    ran = mikas("mem", "dump", "ram", "-o", "x")
    monkeypatch.setattr(MemorySpace, "blocks", blocks)
    assert ran.status == 3
    assert "100 of 256 bytes are in x; --resume" in ran.err
    assert len((tmp_path / "x").read_bytes()) == 100
    manifest = json.loads((tmp_path / "x.json").read_text("utf-8"))
    assert (manifest["bytes_read"], manifest["complete"], manifest["sha256"]) == (100, False, None)
    return tmp_path / "x"


def test_an_interrupted_dump_is_completed_by_resume(mikas, cut, tmp_path):
    assert mikas("mem", "dump", "ram", "-o", "x", "--resume", "--json").object["complete"] is True
    assert mikas("mem", "dump", "ram", "-o", "y").status == 0
    whole = (tmp_path / "y").read_bytes()
    assert cut.read_bytes()[:100] == whole[:100]
    assert len(cut.read_bytes()) == 256
    # Again: there is nothing left to do, and nothing is lost.
    assert mikas("mem", "dump", "ram", "-o", "x", "--resume", "--verify").status == 0
    again = mikas("mem", "dump", "ram", "-o", "x", "--resume", "--json").object
    assert (again["verified"], again["complete"]) == (True, True)


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        (["xram"], "ram 0000–00FF"),
        (["ram", "--from", "1"], "ram 0000–00FF"),
        (["ram", "--port", SIM + "&model=5.4"], "another unit"),
    ],
)
def test_another_dump_is_not_resumed_and_the_file_stays(mikas, cut, argv, message):
    before = cut.read_bytes()
    ran = mikas("mem", "dump", *argv, "-o", "x", "--resume")
    assert ran.status == 2
    assert message in ran.err
    assert cut.read_bytes() == before


@pytest.mark.parametrize("manifest", ["", "[]", "{}", "null", '{"schema": 1}', "\udcff"])
def test_a_damaged_manifest_is_refused(mikas, cut, manifest):
    path = cut.with_name("x.json")
    path.write_bytes(manifest.encode("utf-8", "surrogateescape"))
    for argv in (
        ["dump", "ram", "-o", "x", "--resume"],
        ["verify", "ram", "x"],
        ["diff", "x", "x"],
    ):
        ran = mikas("mem", *argv)
        assert (ran.status, ran.out) == (2, "")
        assert "x.json" in ran.err


def test_a_manifest_with_wrong_values_is_refused(mikas, cut):
    path = cut.with_name("x.json")
    stored = json.loads(path.read_text("utf-8"))
    for change in ({"first": -1}, {"last": 70000}, {"first": "0"}, {"passport": None}, {"more": 1}):
        path.write_text(json.dumps(stored | change), "utf-8")
        assert mikas("mem", "dump", "ram", "-o", "x", "--resume").status == 2


def test_a_file_longer_than_its_manifest_says_is_not_resumed(mikas, cut):
    cut.write_bytes(bytes(300))
    assert mikas("mem", "dump", "ram", "-o", "x", "--resume").status == 2
    assert len(cut.read_bytes()) == 300


def test_verify_names_each_byte_that_differs(mikas, tmp_path):
    data = bytes.fromhex(mikas("mem", "read", "code", "8000", "32", "--json").object["data"])
    (tmp_path / "part").write_bytes(data)
    assert mikas("mem", "verify", "code", "part", "--from", "8000").out == "No differences.\n"
    (tmp_path / "part").write_bytes(bytes([data[0] ^ 0xFF]) + data[1:])
    ran = mikas("mem", "verify", "code", "part", "--from", "8000", "--json").object
    (difference,) = ran["differences"]
    assert difference == {"address": 0x8000, "a": f"{data[0]:02X}", "b": f"{data[0] ^ 0xFF:02X}"}
    assert "8000  " in mikas("mem", "verify", "code", "part", "--from", "8000").out


def test_verify_begins_where_the_manifest_says(mikas):
    mikas("mem", "dump", "code", "-o", "c", "--from", "8000", "--to", "801F")
    assert mikas("mem", "verify", "code", "c", "--json").object["differences"] == []
    ran = mikas("mem", "verify", "xram", "c")
    assert ran.status == 2
    assert "a dump of code, not of xram" in ran.err


def test_diff_compares_two_files_without_a_port(mikas, tmp_path):
    (tmp_path / "a").write_bytes(b"\x01\x02\x03")
    (tmp_path / "b").write_bytes(b"\x01\x05\x03\x04")
    ran = mikas("mem", "diff", "a", "b", "--json", sim="&supplied=0").object  # needs no port
    assert ran["differences"] == [
        {"address": 1, "a": "02", "b": "05"},
        {"address": 3, "a": None, "b": "04"},
    ]
    assert mikas("mem", "diff", "a", "a").out == "No differences.\n"
    assert "0003  –  04" in mikas("mem", "diff", "a", "b").out


def test_diff_goes_by_addresses(mikas):
    mikas("mem", "dump", "ram", "-o", "a", "--from", "10", "--to", "1F")
    mikas("mem", "dump", "ram", "-o", "b", "--from", "18", "--to", "2F")
    found = mikas("mem", "diff", "a", "b", "--json").object["differences"]
    assert [it["address"] for it in found] == [*range(0x10, 0x18), *range(0x20, 0x30)]
    assert all(it["b"] is None for it in found[:8])
    assert all(it["a"] is None for it in found[8:])


def test_a_write_is_announced_read_back_and_journaled(mikas):
    ran = mikas("mem", "write", "ram", "40", "0D 40", "--yes")
    assert ran.out == "ram 0040: 45 6A → 0D 40\n"
    assert "before: 45 6A" in ran.err
    assert "after:  0D 40" in ran.err
    assert "DANGER" not in ran.err
    started, done = mikas.journal
    assert (started["state"], done["state"]) == ("started", "done")
    assert (started["before"], started["after"]) == ("45 6A", "0D 40")
    assert done["outcome"] == "0D 40"
    assert "DANGER" in mikas("mem", "write", "code", "8000", "0D", "--yes").err
    assert len(mikas.journal) == 4


@pytest.mark.parametrize("unknown", ["silent", "01"])
def test_a_unit_without_single_bytes_is_written_in_blocks(mikas, unknown):
    ran = mikas("mem", "write", "ram", "40", "0D", "--yes", sim=f"&missing=bytes&unknown={unknown}")
    assert ran.out == "ram 0040: 45 → 0D\n"
    assert [it["command"] for it in mikas.journal] == ["CWRTI", "CWRITDI"]


@pytest.mark.parametrize(
    ("argv", "missing", "found"),
    [
        (["sfr", "90", "01"], "32", ["SWRITSFR (32)", "there is no block form"]),
        (["xram", "0", "0102"], "14,24", ["CWRITDX (24), CWRITX (14)", "nothing was changed"]),
        (["xram", "0", "01"], "bytes,blocks", ["Nothing was written"]),
    ],
)
@pytest.mark.parametrize("unknown", ["silent", "01"])
def test_a_refused_write_says_what_was_found(mikas, argv, missing, found, unknown):
    words = ["mem", "write", *argv, "--yes"]
    ran = mikas(*words, sim=f"&missing={missing}&unknown={unknown}")
    assert (ran.status, ran.out) == (5, "")
    error = ran.err.splitlines()[-1]
    assert all(each in error for each in found), error
    is_one_short_paragraph(error)
    is_russian(mikas(*words, "--lang", "ru").err)


def test_ctrl_c_in_the_middle_says_what_to_read(mikas, monkeypatch):
    from mikas.client.memory.writing import SpaceWriter

    some = SpaceWriter._some  # noqa: SLF001

    def interrupted(self, address, *rest):
        if address > 0x1000:
            raise KeyboardInterrupt
        return some(self, address, *rest)

    monkeypatch.setattr(SpaceWriter, "_some", interrupted)
    ran = mikas("mem", "write", "xram", "1000", "00" * 300, "--yes")
    assert ran.status == 130
    assert "some of the bytes may be written. Read them: mikas mem read xram 1000 300." in ran.err
    assert [it["state"] for it in mikas.journal] == ["started", "interrupted"]
    is_russian(mikas("mem", "write", "xram", "1000", "00" * 300, "--yes", "--lang", "ru").err)
    mikas.answers()
    monkeypatch.setattr("sys.stdin.readline", _interrupt)
    assert "may be written" not in mikas("mem", "write", "xram", "0", "01").err


def _interrupt() -> str:
    raise KeyboardInterrupt
