"""Recordings by mikas itself, which the mutations start from: the command line on a virtual unit.

On the simulated clock, so each is the same at every run of one version of mikas.
"""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

from mikas.cli.main import run
from mikas.i18n import Text
from mikas.recording.annotations.events import comment_note, faults_note, note_of
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.scan import RawBlock, scan
from mikas.recording.capture.writer import append_note
from mikas.sampling.events import FaultReading, Gap, Marker, StateChanged, TextNote

_SIM: Final = "sim:?clock=simulated&seed=3"
_FEW: Final = ("TWAT", "FREQ", "INJ/2", "DET")
_LOG: Final = ("log", "-o", "FILE")
_COMMANDS: Final = {
    "single": (f"{_SIM}&faults=13,25", *_LOG, "--method=single", "--duration=0.5", *_FEW),
    "batch": (f"{_SIM}&scenario=city", *_LOG, "--method=batch", "--duration=0.5"),
    "list": (f"{_SIM}&scenario=warm-idle", *_LOG, "--method=list", "--duration=0.6", *_FEW),
    "stream": (f"{_SIM}&scenario=city", *_LOG, "--method=stream", "--duration=0.5", *_FEW),
    "strokes": (f"{_SIM}&scenario=highway", *_LOG, "--method=stroke1", "--count=12", *_FEW),
    "damaged": (f"{_SIM}&damaged=0.1&lost=0.05&noise=0.1", *_LOG, "--duration=2", *_FEW),
    "silent": (f"{_SIM}&scenario=key-off", *_LOG, "--method=batch", "--duration=3", *_FEW),
    "no echo": (f"{_SIM}&echo=0&model=5.4", *_LOG, "--method=list", "--duration=0.3", *_FEW),
    "faults": (f"{_SIM}&faults=13,53", "faults", "--capture=FILE"),
    "info": (f"{_SIM}&unknown=01", "info", "--capture=FILE"),
    "memory": (f"{_SIM}&raw_checksum=1", "mem", "read", "ram", "0x20", "40", "--capture=FILE"),
}


def recordings() -> dict[str, bytes]:
    """Return the recordings by name, 1 to 60 KB each."""
    with TemporaryDirectory(prefix="mikas-fuzz-") as folder, _own_state(Path(folder)):
        made = {name: _recorded(Path(folder) / "it.pcapng", *it) for name, it in _COMMANDS.items()}
        made["noted"] = _noted(Path(folder) / "noted.pcapng", made["list"])
    made["sections"] = made["info"] + made["faults"] + made["list"] + made["stream"]
    made["big-endian"] = big_endian(made["noted"])
    made["both orders"] = big_endian(made["batch"]) + made["single"]
    return made


def big_endian(data: bytes) -> bytes:
    """Return the recording in the other byte order."""
    parsed = (
        pcapng.parse(it.kind, it.body, it.order)
        for it in scan(io.BytesIO(data))
        if isinstance(it, RawBlock)
    )
    return b"".join(pcapng.encode(block, ">") for block in parsed if block is not None)


def _recorded(path: Path, port: str, *words: str) -> bytes:
    path.unlink(missing_ok=True)
    command = [word.replace("FILE", str(path)) for word in words]
    with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()) as said:
        status = run([*command, "--port", port])
    assert path.is_file(), (status, said.getvalue())
    return path.read_bytes()


def _noted(path: Path, data: bytes) -> bytes:
    """Return the recording with a note of every kind that a person or a bad line causes."""
    path.write_bytes(data)
    why = Text("no echo", "нет эха")
    for event in (
        Marker(0.2, "гора / hill"),
        TextNote(0.3, "смешались 5 л воды\nв баке"),
        Gap(0.4, 0.35, 0.45, why),
        Gap(0.5, 0.5, None, why),
        StateChanged(0.5, "echo-only", text=why, reason=why),
    ):
        append_note(path, note_of(event))
    append_note(path, faults_note(0.1, [FaultReading(0.05, (13, 53)), FaultReading(0.06, ())]))
    append_note(path, comment_note(0.9, "после ремонта"))
    return path.read_bytes()


@contextmanager
def _own_state(folder: Path) -> Iterator[None]:
    """Keep the user's files out of it."""
    before = dict(os.environ)
    os.environ.update(MIKAS_STATE=str(folder / "state"), XDG_CONFIG_HOME=str(folder / "config"))
    try:
        yield
    finally:
        os.environ.clear()
        os.environ.update(before)
