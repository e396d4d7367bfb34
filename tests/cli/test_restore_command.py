"""`mikas mem restore`: the question, the result and its status, interruptions."""

from __future__ import annotations

import pytest
from cli_harness import is_one_short_paragraph, is_russian

from mikas.client.memory.spaces import MemorySpace
from mikas.errors import LinkLost


@pytest.fixture
def dump(mikas, tmp_path):
    """A dump of RAM 20–5F with three bytes changed."""
    mikas("mem", "dump", "ram", "-o", "d", "--from", "20", "--to", "5F")
    data = bytearray((tmp_path / "d").read_bytes())
    for offset in (0, 1, 0x3F):
        data[offset] ^= 0xFF
    (tmp_path / "d").write_bytes(data)
    return data


def test_without_a_terminal_it_only_compares(mikas, dump):
    ran = mikas("mem", "restore", "ram", "d")
    assert (ran.status, ran.out) == (6, "")
    assert "Restore ram 0020–005F: of 64 bytes 3 differ (0020–0021, 005F)" in ran.err
    assert "d has been changed since it was read" in ran.err
    is_russian(mikas("mem", "restore", "ram", "d", "--lang", "ru").err, names=("d",))


def test_it_writes_and_reads_back_what_differs(mikas, dump):
    ran = mikas("mem", "restore", "ram", "d", "--yes", "--json")
    assert ran.status == 0
    assert ran.object == {"schema": 1, "written": 3, "same": 61, "differences": []}
    assert [entry["after"] for entry in mikas.journal[::2]] == [
        dump[:2].hex(" ").upper(),
        f"{dump[-1]:02X}",
    ]
    same = mikas("mem", "dump", "ram", "-o", "e", "--from", "20", "--to", "5F")
    assert same.status == 0
    nothing = mikas("mem", "restore", "ram", "e")  # a new virtual unit: the same bytes
    assert (nothing.status, nothing.err) == (0, "")
    assert "written and read back: 0; the same before: 64" in nothing.out


def test_the_answer_no_restores_nothing(mikas, dump):
    mikas.answers("n")
    assert mikas("mem", "restore", "ram", "d").status == 6
    mikas.answers("y")
    assert mikas("mem", "restore", "ram", "d").status == 0


def test_code_is_said_to_be_dangerous(mikas):
    mikas("mem", "dump", "xram", "-o", "x", "--to", "F")
    ran = mikas("mem", "restore", "code", "x", "--ignore-manifest", "--from", "8000")
    assert ran.status == 6
    assert "DANGER" in ran.err


@pytest.mark.parametrize(
    "argv",
    [
        ["xram", "d"],
        ["ram", "absent"],
        ["ram", "d", "--from", "21"],
        ["ram", "d", "--ignore-manifest"],
        ["ram", "d", "--ignore-manifest", "--from", "C1"],
        ["ram", "d", "--port", "sim:?clock=simulated&model=5.4"],
        ["ram"],
    ],
)
def test_a_dump_that_does_not_fit_is_refused(mikas, dump, argv):
    ran = mikas("mem", "restore", *argv, "--yes")
    assert (ran.status, ran.out) == (2, "")
    is_one_short_paragraph(ran.err)
    is_russian(
        mikas("mem", "restore", *argv, "--yes", "--lang", "ru").err, names=("d", "absent", "FILE")
    )


@pytest.mark.parametrize(
    ("end", "status"), [(KeyboardInterrupt, 130), (LinkLost(url="sim:", problem="out"), 3)]
)
def test_an_interruption_is_resumed(mikas, monkeypatch, dump, tmp_path, end, status):
    write_run = MemorySpace._write_run  # noqa: SLF001

    def first_only(self, run):
        if run.address != 0x20:
            raise end
        return write_run(self, run)

    monkeypatch.setattr(MemorySpace, "_write_run", first_only)
    ran = mikas("mem", "restore", "ram", "d", "--yes")
    assert ran.status == status
    assert "Stopped: 2 of 3 different bytes were written and read back. --resume" in ran.err
    monkeypatch.setattr(MemorySpace, "_write_run", write_run)
    again = mikas("mem", "restore", "ram", "d", "--yes")
    assert again.status == 2
    assert "--resume" in again.err
    declined = mikas("mem", "restore", "ram", "d", "--resume")
    assert (declined.status, "Stopped" in declined.err) == (6, False)
    assert mikas("mem", "restore", "ram", "d", "--yes", "--resume").status == 0
    assert not (tmp_path / "d.restore.json").exists()


def test_ctrl_c_at_the_question_leaves_nothing(mikas, monkeypatch, dump, tmp_path):
    def interrupted():
        raise KeyboardInterrupt

    mikas.answers("y")
    monkeypatch.setattr("sys.stdin.readline", interrupted)
    ran = mikas("mem", "restore", "ram", "d")
    assert ran.status == 130
    assert "Stopped" not in ran.err
    assert not (tmp_path / "d.restore.json").exists()


def test_cells_that_keep_their_value_are_named(mikas, monkeypatch, dump):
    from mikas.virtual.memory import EcuMemory

    write = EcuMemory.write

    def kept(self, space, address, data):
        if address != 0x5F:
            write(self, space, address, data)

    monkeypatch.setattr(EcuMemory, "write", kept)
    ran = mikas("mem", "restore", "ram", "d", "--yes", "--json")
    assert ran.status == 5
    (difference,) = ran.object["differences"]
    assert (difference["address"], difference["b"]) == (0x5F, f"{dump[-1]:02X}")
    assert ran.object["written"] == 2
    shown = mikas("mem", "restore", "ram", "d", "--yes")
    assert "not taken (unit | file): 005F" in shown.err
