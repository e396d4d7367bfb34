"""The program as it is run: in processes of its own, on ptys, with signals and broken pipes."""

from __future__ import annotations

import fcntl
import json
import os
import pty
import re
import select
import signal
import struct
import subprocess
import sys
import termios
import time
from contextlib import contextmanager
from pathlib import Path

import pytest

from mikas.recording import CaptureReader
from mikas.recording.capture.reader import Packet, Problem
from virtual.serving import a_pty_port, serving

pytestmark = pytest.mark.realtime
PATIENCE = 20


@pytest.fixture
def start(tmp_path):
    """Starts `mikas` in an environment of its own; whatever is left is ended."""
    environment = {
        "PATH": os.environ["PATH"], "HOME": str(tmp_path), "LANG": "C.UTF-8",
        "XDG_STATE_HOME": str(tmp_path / "state"), "XDG_CONFIG_HOME": str(tmp_path / "config"),
        "PYTHONPATH": os.environ.get("PYTHONPATH", ""),
        "PYTHONDONTWRITEBYTECODE": "1",  # a small disk would cut it, for all other tests, too
    }  # fmt: skip
    running = []

    def started(*argv: str, terminal: str = "xterm", more=(), **settings) -> subprocess.Popen:
        process = subprocess.Popen(
            [sys.executable, "-c", "from mikas.cli.main import main; main()", *argv],
            cwd=tmp_path,
            env=environment | {"TERM": terminal} | dict(more),
            **{"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE,
               "text": True, "encoding": "utf-8", **settings},
        )  # fmt: skip
        running.append(process)
        return process

    yield started
    for process in running:
        process.kill()
        process.wait()
        for stream in (process.stdout, process.stderr):
            if stream:
                stream.close()


@pytest.fixture
def url():
    """The address of a virtual ECU on a pty, served from a thread: for what is not about `sim`."""
    with serving(a_pty_port) as served:
        yield served.url


@pytest.fixture
def sim(start):
    """A virtual ECU on a pty; its process and address."""
    process = start("sim")
    return process, process.stdout.readline().strip()


def test_the_address_of_sim_is_the_first_line(start, sim):
    process, url = sim
    assert re.fullmatch(r"/dev/\S+", url)
    out, err = start("read", "TWAT", "--json", "--port", url).communicate(timeout=PATIENCE)
    assert json.loads(out)["readings"]["TWAT"]["value"] > 0, err
    process.send_signal(signal.SIGINT)
    assert process.wait(PATIENCE) == 130


def test_memory_of_a_unit_without_single_bytes_is_written_in_blocks(start):
    with serving(a_pty_port, {"missing": "bytes"}) as unit:
        line = ("--port", unit.url, "--timeout", "0.2")
        write = start("mem", "write", "xram", "1000", "0D", "--yes", "--json", *line)
        out, err = write.communicate(timeout=PATIENCE)
        assert json.loads(out)["after"] == "0D", err
        out, err = start("mem", "read", "xram", "1000", *line).communicate(timeout=PATIENCE)
        assert out.split()[:2] == ["1000", "0D"], err


def test_sim_on_tcp_prints_events(start):
    process = start("sim", "--tcp", "127.0.0.1:0", "--json")
    url = json.loads(process.stdout.readline())["url"]
    assert url.startswith("socket://127.0.0.1:")
    client = start("raw", "611A", "--port", url)
    out, err = client.communicate(timeout=PATIENCE)
    assert re.fullmatch("[0-9A-F]{2}\n", out), err
    process.send_signal(signal.SIGINT)
    events = [json.loads(line) for line in process.communicate(timeout=PATIENCE)[0].splitlines()]
    assert process.returncode == 130
    assert events
    assert all({"schema", "time", "event", "data"} == set(event) for event in events)


def test_ctrl_c_ends_watch_and_log(start, url, tmp_path):
    line = ("--port", url, "--timeout", "2")  # the unit is in this process, which may be starved
    watch = start("watch", "TWAT", *line, "--json")
    assert json.loads(watch.stdout.readline())["values"]["TWAT"] > 0
    watch.send_signal(signal.SIGINT)
    out, err = watch.communicate(timeout=PATIENCE)
    assert (watch.returncode, err.strip()) == (130, "")
    assert [json.loads(line)["schema"] for line in out.splitlines()] == [1] * len(out.splitlines())

    log = start("log", "-o", "a.pcapng", "TWAT", *line, "--json")
    assert json.loads(log.stdout.readline())["values"]["TWAT"] > 0  # no error, after which it ends
    log.send_signal(signal.SIGINT)
    _, err = log.communicate(timeout=PATIENCE)
    assert log.returncode == 130
    assert "a.pcapng:" in err
    assert all(isinstance(it, Packet) for it in CaptureReader(tmp_path / "a.pcapng"))


def test_a_killed_log_leaves_a_valid_file(start, url, tmp_path):
    log = start("log", "-o", "a.pcapng", "TWAT", "--port", url, "--json")
    for _ in range(5):
        log.stdout.readline()
    log.kill()
    assert log.wait(PATIENCE) == -signal.SIGKILL
    items = list(CaptureReader(tmp_path / "a.pcapng"))
    assert len([it for it in items if isinstance(it, Packet)]) > 10
    assert not [it for it in items if isinstance(it, Problem)]


def lines_until(stream, found) -> list[dict]:
    """JSON lines up to the first that `found` likes."""
    lines = []
    while not (lines and found(lines[-1])):
        line = stream.readline()
        assert line, "ended before it came"
        lines.append(json.loads(line))
    return lines


def test_an_adapter_that_goes_and_comes_back_is_a_gap_with_its_reason(start, sim, tmp_path):
    """“Probing goes on for ever without a hand on the keyboard, the recording stays open and gets
    a gap with its reason”: the address stays, what is behind it goes away and comes back.
    """
    process, url = sim
    adapter = tmp_path / "adapter"
    adapter.symlink_to(url)
    log = start("log", "-o", "a.pcapng", "TWAT", "--port", str(adapter), "--json")
    for _ in range(5):  # until the unit's passports are known, so that it is known again
        lines_until(log.stdout, lambda line: line["values"]["TWAT"])
    adapter.unlink()
    process.kill()
    gaps = lines_until(log.stdout, lambda line: line["gap"])
    assert gaps[-1]["values"] == {"TWAT": None}
    gaps += lines_until(log.stdout, lambda line: line["gap"])  # and another, while it waits
    other = start("sim")
    adapter.symlink_to(other.stdout.readline().strip())
    lines_until(log.stdout, lambda line: line["values"]["TWAT"])
    log.send_signal(signal.SIGINT)
    _, err = log.communicate(timeout=PATIENCE)
    assert log.returncode == 130
    reported = err.splitlines()
    assert reported[0] == "No adapter. Waiting; sampling resumes by itself."
    assert re.fullmatch(r"Back after \d+ s\.", reported[1])
    assert "1 gap" in reported[2]
    reader = CaptureReader(tmp_path / "a.pcapng")
    assert all(isinstance(it, Packet) for it in reader)
    (gap,) = (note.data for note in reader.notes() if note.kind == "gap")
    assert gap["ended"] > gap["began"]
    assert "is gone" in gap["reason"]["en"]
    assert not list(tmp_path.glob("a-*"))  # the same unit: the same file


def test_another_car_gets_a_file_of_its_own(start, tmp_path):
    first = start("sim", "--tcp", "127.0.0.1:0")
    url = first.stdout.readline().strip()
    log = start("log", "-o", "a.pcapng", "TWAT", "--port", url, "--json")
    lines_until(log.stdout, lambda line: line["values"]["TWAT"])
    first.kill()
    first.wait(PATIENCE)
    lines_until(log.stdout, lambda line: line["gap"])
    second = start("sim", "--model", "5.4", "--tcp", url.removeprefix("socket://"))
    assert second.stdout.readline().strip() == url
    lines_until(log.stdout, lambda line: line["values"]["TWAT"])
    log.send_signal(signal.SIGINT)
    _, err = log.communicate(timeout=PATIENCE)
    assert "Another unit answers: Mikas 5.4" in err
    assert "Recording continues in a-2.pcapng." in err
    for name in ("a.pcapng", "a-2.pcapng"):
        items = list(CaptureReader(tmp_path / name))
        assert items
        assert all(isinstance(it, Packet) for it in items)


def test_a_disk_that_is_full_costs_no_sample(start, url, tmp_path):
    import resource

    log = start(
        "log", "-o", "a.pcapng", "TWAT", "--port", url, "--json", "--duration", "3",
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (5_000, 5_000)),
    )  # fmt: skip
    out, err = log.communicate(timeout=PATIENCE)
    assert log.returncode == 2
    assert err.count("RECORDING STOPPED") == 1
    *samples, error = [json.loads(line) for line in out.splitlines()]
    assert "code" in error["error"]
    assert samples[-1]["time"] - samples[0]["time"] > 2
    assert all(isinstance(it, Packet) for it in CaptureReader(tmp_path / "a.pcapng"))
    assert 4_000 < (tmp_path / "a.pcapng").stat().st_size <= 5_000


def test_enter_marks_a_moment(start, tmp_path):
    with terminal() as (behind, front):
        log = start(
            "log", "-o", "a.pcapng", "TWAT", "--port", "sim:", stdin=front, stdout=front,
            stderr=front, start_new_session=True,
            preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0),
        )  # fmt: skip
        read_until(behind, " samples")
        os.write(behind, "горка\n".encode())
        assert "Marker 1 “горка”." in read_until(behind, "Marker 1 “горка”.")
        os.write(behind, b"\x03")
        read_until(behind, " KiB")
        assert log.wait(PATIENCE) == 130
    (note,) = (n for n in CaptureReader(tmp_path / "a.pcapng").notes() if n.kind == "marker")
    assert note.data == {"label": "горка"}


def test_a_reader_that_closes_its_pipe_ends_watch_cleanly(start, url):
    watch = start("watch", "TWAT", "--port", url)
    watch.stdout.readline()
    watch.stdout.close()
    watch.stdout = None
    assert watch.wait(PATIENCE) == 0
    assert watch.stderr.read() == ""


def test_closed_standard_streams_are_no_crash(start):
    for closed in ((1,), (0, 1), (0, 1, 2)):
        process = start(
            "read", "TWAT", "--port", "sim:?clock=simulated",
            preexec_fn=lambda closed=closed: [os.close(number) for number in closed],
            stdin=None, stdout=None, stderr=None if 2 in closed else subprocess.PIPE,
        )  # fmt: skip
        assert process.wait(PATIENCE) == 0


def test_doctor_finds_a_wire_of_another_baud_rate(start):
    process = start("sim", "--baud", "4800")
    url = process.stdout.readline().strip()
    doctor = start("doctor", "--port", url, "--json", "--timeout", "0.2")
    out, err = doctor.communicate(timeout=PATIENCE)
    steps = {step["name"]: step for step in json.loads(out)["steps"]}
    assert doctor.returncode == 3, err
    assert steps["baud"]["ok"] is False
    assert "instead of 9600" in steps["baud"]["detail"]
    measured = int(re.search(r"about (\d+)", steps["baud"]["detail"])[1])
    assert 4000 < measured < 5200
    assert steps["ecu"]["ok"] is True


def test_a_full_disk_behind_stdout_is_one_sentence(start):
    for argv in (["params"], ["params", "--json"], ["wireshark"], ["--help"], ["no", "--json"]):
        with Path("/dev/full").open("w", encoding="utf-8") as full:
            process = start(*argv, stdout=full)
            _, err = process.communicate(timeout=PATIENCE)
        assert process.returncode == 2
        assert err.count("\n") == 1
        assert "No space left on device; make room" in err


@contextmanager
def terminal(rows: int = 24, columns: int = 80):
    """A terminal of this size: what is behind it, and what a program gets."""
    behind, front = pty.openpty()
    fcntl.ioctl(front, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
    try:
        yield behind, front
    finally:
        os.close(behind)
        os.close(front)


def read_until(behind: int, wanted: str) -> str:
    """What comes from the terminal, up to `wanted`."""
    got = ""
    deadline = time.monotonic() + PATIENCE
    while wanted not in got:
        assert select.select([behind], [], [], deadline - time.monotonic())[0], got
        got += os.read(behind, 65536).decode("utf-8", "replace")
    return got


def test_the_live_table_is_drawn_and_the_terminal_left_as_it_was(start):
    with terminal() as (behind, front):
        watch = start("watch", "--port", "sim:", "--lang", "ru", stdin=front, stdout=front,
                      stderr=front, start_new_session=True)  # fmt: skip
        got = read_until(behind, "идёт опрос")
        assert "\x1b[?1049h" in got
        watch.send_signal(signal.SIGINT)
        got += read_until(behind, "\x1b[?1049l")
        got += read_until(behind, "TWATI")
        assert "\x1b[?25h" in got
        assert "Traceback" not in got
        assert watch.wait(PATIENCE) == 130


def test_a_killed_restore_is_resumed(start, url, tmp_path):
    def ran(*argv):
        process = start("mem", *argv, "--port", url)
        out, err = process.communicate(timeout=PATIENCE)
        return process.returncode, out, err

    assert ran("dump", "xram", "-o", "x", "--to", "7F")[0] == 0
    wanted = bytes(value ^ 0x0D for value in (tmp_path / "x").read_bytes())
    (tmp_path / "x").write_bytes(wanted)
    restore = start("mem", "restore", "xram", "x", "--yes", "--block", "16", "--port", url)
    while not (tmp_path / "x.restore.json").exists():
        assert restore.poll() is None
        select.select([], [], [], 0.01)
    restore.kill()
    restore.wait(PATIENCE)
    status, _, err = ran("restore", "xram", "x", "--yes")
    assert (status, "--resume" in err) == (2, True)
    status, out, err = ran("restore", "xram", "x", "--yes", "--resume", "--json")
    assert status == 0, err
    assert json.loads(out)["written"] > 0
    assert ran("verify", "xram", "x")[1] == "No differences.\n"


def test_a_list_is_read_by_a_later_process(start, url):
    for argv in (["list", "set", "TWAT", "INJ", "--yes"], ["list", "read", "--json"]):
        ran = start(*argv, "--port", url)
        out, err = ran.communicate(timeout=PATIENCE)
        assert ran.returncode == 0, err
    assert list(json.loads(out)["readings"]) == ["TWAT", "INJ"]


def test_ctrl_c_shows_the_codes_that_a_scan_has_found(start, url):
    with terminal() as (behind, front):
        scan = start("scan", "--json", "--port", url, stderr=front)
        read_until(behind, "found 21")
        scan.send_signal(signal.SIGINT)
        out, _ = scan.communicate(timeout=PATIENCE)
    assert scan.returncode == 130
    found = json.loads(out)
    assert len(found["codes"]) == found["promised"] == 21
    assert 21 <= found["requested"] < 256


def until_it_sleeps(pid: int) -> None:
    """Wait until the process waits for its terminal, or has ended (Linux).

    Python notices a signal that comes just before only when it has read a line.
    """
    status = Path(f"/proc/{pid}/stat")
    while status.exists() and status.read_text().rpartition(")")[2].split()[0] not in "SZ":
        pass


def test_a_question_at_a_terminal_takes_yes_no_end_and_ctrl_c(start, tmp_path):
    argv = ("write", "UOZ", "10", "--port", "sim:?clock=simulated")
    state = {"MIKAS_STATE": str(tmp_path / "state/mikas")}  # else a virtual unit has no journal
    for answer, status in (("n\n", 6), ("y\n", 0), ("\x04", 6), ("\x03", 130)):
        with terminal() as (behind, front):
            process = start(
                *argv, stdin=front, stdout=front, stderr=front, start_new_session=True,
                more=state, preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0),
            )  # fmt: skip
            got = read_until(behind, "Do it? [y/N]")
            assert "10.0 ° crank (14)" in got
            until_it_sleeps(process.pid)
            os.write(behind, answer.encode())
            assert process.wait(PATIENCE) == status
    (journal,) = tmp_path.glob("state/mikas/journal.jsonl")
    assert len(journal.read_text("utf-8").splitlines()) == 2


def test_a_dumb_terminal_gets_plain_lines(start):
    with terminal() as (behind, front):
        process = start(
            "watch", "TWAT", "--count", "2", "--port", "sim:?clock=simulated", stdout=front,
            terminal="dumb",
        )  # fmt: skip
        got = read_until(behind, "time\tTWAT")
        assert process.wait(PATIENCE) == 0
        assert "\x1b" not in got
