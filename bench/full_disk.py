"""A disk that is full at any moment: the commands on a file system of some kilobytes.

The disk is a tmpfs in a mount namespace of its own. Where that can't be had, no process may write
more than so many bytes to a file (RLIMIT_FSIZE), which is another error (EFBIG) and no real disk.
"""

from __future__ import annotations

import ctypes
import io
import json
import os
import resource
import signal
import tempfile
from collections import Counter
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass, field
from pathlib import Path
from random import Random

from bench.rows import Row, Theme
from mikas.cli.failures import DONE, USAGE
from mikas.cli.main import run as run_command
from mikas.client.memory.dumps import read_manifest
from mikas.recording.capture.reader import CaptureReader, Packet

_NEW_NAMESPACE = 0x0002_0000  # CLONE_NEWNS
_PRIVATE = 1 << 18 | 1 << 14  # MS_PRIVATE | MS_REC
_SIM = "sim:?clock=simulated"
_WORDS = {"en": "room", "ru": "мест"}
_METHOD = """\
The commands on a disk with room for 4 to 60 KB (`scan`: none; seed {seed}), {runs} times, with
the virtual unit on the simulated clock: {disk}. There is a loss if the end status is not 2, if the
message does not speak of room (in English and Russian by turns), if what was kept can't be read, if
a half-written file stays, or if the same command does not work once there is room again (a dump:
with --resume; a recording: with another name)."""


@dataclass
class Tried:
    """What one command did on full disks."""

    count: int = 0
    lost: int = 0
    states: Counter[str] = field(default_factory=Counter)


def measured(runs: int, seed: int) -> Theme:
    """Run in a fork, whose mounts nothing else sees; return the table."""
    heard, told = os.pipe()
    if not (child := os.fork()):
        status = 1
        try:
            with tempfile.TemporaryDirectory(prefix="mikas-full-") as folder:
                found = _Disk(Path(folder), runs, seed).tried()
            os.write(told, json.dumps(found).encode())
            status = 0
        finally:
            os._exit(status)
    os.close(told)
    with os.fdopen(heard) as result:
        disk, found = json.loads(result.read())
    os.waitpid(child, 0)
    rows = [
        Row(
            f"{name}: losses",
            [lost],
            "",
            0,
            at_most=0,
            aside=f"{count} runs; " + ", ".join(f"{n} {state}" for state, n in states.items()),
        )
        for name, (count, lost, states) in found.items()
    ]
    return Theme("A full disk", _METHOD.format(runs=runs, seed=seed, disk=disk), rows)


class _Disk:
    def __init__(self, place: Path, runs: int, seed: int) -> None:
        self._runs = runs
        self._seed = seed
        self._place = place
        self._is_mounted = False
        self._source = self._place / "source.pcapng"

    def tried(self) -> tuple[str, dict[str, tuple[int, int, dict[str, int]]]]:
        """Try the commands in turn; return how, and the outcomes."""
        os.environ["MIKAS_STATE"] = str(self._place / "state")
        self._is_mounted = _own_namespace()
        status, said = _said("log", "-o", str(self._source), "--port", _SIM, "--duration=30")
        assert status == DONE, said
        commands = {
            "`log`": ("log", "-o", "it.pcapng", "--port", _SIM, "--duration=20"),
            "`mem dump`": ("mem", "dump", "xram", "-o", "it.bin", "--to", "BFFF", "--port", _SIM),
            "`export`": ("export", str(self._source), "-o", "it.csv"),
            "`report`": ("report", str(self._source), "-o", "it.html"),
            "`scan`": ("scan", "-o", "it.toml", "--port", _SIM),
        }
        found = {name: Tried() for name in commands}
        for number in range(self._runs):
            name = list(commands)[number % len(commands)]
            tried = found[name]
            tried.count += 1
            random = Random(f"{self._seed}:{number}")
            try:
                state = self._try(commands[name], random, "ru" if number % 2 else "en")
            except Exception as error:
                tried.lost += 1
                state = f"lost ({type(error).__name__}: {error})"
            tried.states[state] += 1
        how = "a tmpfs" if self._is_mounted else "no tmpfs could be mounted, so RLIMIT_FSIZE"
        return how, {name: (it.count, it.lost, dict(it.states)) for name, it in found.items()}

    def _try(self, words: tuple[str, ...], random: Random, language: str) -> str:
        disk = self._place / "disk"
        disk.mkdir(exist_ok=True)
        kilobytes = 4 if words[0] == "scan" else random.randrange(4, 64, 4)
        self._mount(disk, kilobytes)
        (disk / "state").mkdir()
        if words[0] == "scan":  # its file would fit
            (disk / "other").write_bytes(bytes(kilobytes << 10))
        os.environ["MIKAS_STATE"] = str(disk / "state")
        file = next(word for word in words if word.startswith("it."))
        command = [str(disk / word) if word == file else word for word in words]
        try:
            status, said = _said(*command, "--lang", language)
            if status == DONE:
                return "fitted"
            assert status == USAGE, (status, said)
            assert _WORDS[language] in said, said
            kept = _kept(disk / file)
            assert [path.name for path in disk.iterdir() if path.suffix in (".part", ".new")] == []
            self._give_room(disk)
            if words[0] == "mem" and (disk / file).exists():
                command.append("--resume")
            if words[0] == "log":
                command[command.index(str(disk / file))] = str(disk / "next.pcapng")
            status, said = _said(*command)
            assert status == DONE, (status, said)
            return kept
        finally:
            self._unmount(disk)

    def _mount(self, disk: Path, kilobytes: int) -> None:
        if self._is_mounted:
            _mount(str(disk), f"size={kilobytes}k")
            return
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (kilobytes << 10, resource.RLIM_INFINITY))

    def _give_room(self, disk: Path) -> None:
        if self._is_mounted:
            _mount(str(disk), "remount,size=8m")
        else:
            resource.setrlimit(resource.RLIMIT_FSIZE, (-1, -1))

    def _unmount(self, disk: Path) -> None:
        if self._is_mounted:
            assert not _LIBC.umount2(str(disk).encode(), 2), os.strerror(ctypes.get_errno())


def _said(*words: str) -> tuple[int, str]:
    out = io.StringIO()
    with redirect_stdout(out), redirect_stderr(out):
        status = run_command(list(words))
    return status, out.getvalue()


def _kept(file: Path) -> str:
    """Return what is left of a file that did not fit, after reading it."""
    if not file.exists():
        return "nothing written"
    if file.suffix == ".bin":
        manifest = read_manifest(file)
        assert manifest is not None
        assert not manifest.complete
        return "a part that was gone on with"
    assert file.suffix == ".pcapng", "half a file"
    items = list(CaptureReader(file))
    assert items
    assert all(isinstance(item, Packet) for item in items)
    return "a whole recording to there"


_LIBC = ctypes.CDLL(None, use_errno=True)


def _own_namespace() -> bool:
    """Make mounts private to this process. Needs root; False: it is not to be had."""
    if _LIBC.unshare(_NEW_NAMESPACE):
        return False
    return not _LIBC.mount(None, b"/", None, _PRIVATE, None)


def _mount(place: str, options: str) -> None:
    flags = 32 if options.startswith("remount,") else 0  # MS_REMOUNT
    data = options.removeprefix("remount,").encode()
    if _LIBC.mount(b"tmpfs", place.encode(), b"tmpfs", flags, data):
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
