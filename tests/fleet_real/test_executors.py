"""The same work in processes and on a Dask cluster; workers that die; no scheduler at all."""

from __future__ import annotations

import errno
import logging
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import partial
from multiprocessing.process import BaseProcess
from pathlib import Path

import pytest

from fleet_rig import BEGAN, DAY, SETTINGS, ask, counts, files_of, make
from mikas.errors import FleetError, MissingExtra, UsageError, refusal_of
from mikas.fleet import executors
from mikas.fleet.adding import add, plan
from mikas.fleet.executors import DaskRunner, ProcessRunner, runner_of
from mikas.fleet.job import work

pytestmark = pytest.mark.realtime
TOTAL = "SELECT count(*), count(DISTINCT drive) FROM samples"


def some(folder: Path, count: int = 6) -> Path:
    for number in range(count):
        make(folder / f"{number}.pcapng", began=BEGAN + number * DAY)
    (folder / "bad.pcapng").write_text("no")
    return folder


def add_by(runner, folder: Path, to: Path, on_file=lambda _: None):
    try:
        return add(plan([str(folder)], str(to), SETTINGS), str(to), SETTINGS, runner, on_file)
    finally:
        runner.close()


def test_processes_do_the_same_as_this_process(tmp_path) -> None:
    result = add_by(ProcessRunner(2), some(tmp_path / "in"), tmp_path / "set")
    assert counts(result) == (6, 0, 0, 1)
    assert ask(tmp_path / "set", TOTAL) == [(6 * 239, 6)]


def kill_at(file, name: str, dataset: str):
    """The work on a file; a process that comes to the named one dies of it."""
    if name in file.url:
        os.kill(os.getpid(), signal.SIGKILL)
    return work(file, dataset, SETTINGS)


@pytest.mark.posix
def test_a_process_that_dies_takes_at_most_its_own_file_with_it(tmp_path) -> None:
    files = plan([str(some(tmp_path / "in"))], str(tmp_path / "set"), SETTINGS).files
    runner = ProcessRunner(2)
    job = partial(kill_at, name="3.pcapng", dataset=str(tmp_path / "set"))
    try:
        outcomes = list(runner.outcomes(job, files))
    finally:
        runner.close()
    bad = {Path(it.file.url).name for it in outcomes if it.entry is None}
    assert bad == {"3.pcapng", "bad.pcapng"}
    assert len(outcomes) == 7


def test_where_no_further_process_can_be_started_the_work_goes_on_with_those_there_are(
    tmp_path, monkeypatch
) -> None:
    start, started = BaseProcess.start, []

    def refuse(process) -> None:
        if started:
            raise BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN))
        started.append(process)
        start(process)

    monkeypatch.setattr(BaseProcess, "start", refuse)
    result = add_by(ProcessRunner(4), some(tmp_path / "in"), tmp_path / "set")
    assert counts(result) == (6, 0, 0, 1)
    assert len(started) == 1


@pytest.mark.parametrize(
    "error",
    [
        BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN)),
        RuntimeError("can't start new thread"),
        MemoryError(),
    ],
    ids=["process", "thread", "memory"],
)
def test_where_no_process_can_be_started_the_refusal_is_raised(
    tmp_path, monkeypatch, error
) -> None:
    def refuse(_: object) -> None:
        raise error

    monkeypatch.setattr(BaseProcess, "start", refuse)
    with pytest.raises(type(error)) as caught:
        add_by(ProcessRunner(2), some(tmp_path / "in"), tmp_path / "set")
    assert refusal_of(caught.value) is not None


class OneEnd:
    """A worker's end of its pipe: jobs, and the answers given."""

    def __init__(self, *jobs) -> None:
        self.jobs, self.answers = list(jobs), []

    def recv(self):
        if not self.jobs:
            raise EOFError
        return self.jobs.pop(0)

    def send(self, answer) -> None:
        self.answers.append(answer)


def test_a_worker_that_may_start_no_thread_does_its_jobs(monkeypatch) -> None:
    """It does not notice the end of the program before the end of its job then."""

    def refuse(_: object) -> None:
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(threading.Thread, "start", refuse)
    monkeypatch.setattr(signal, "signal", lambda *_: None)
    end = OneEnd((str.upper, "a"), (str.upper, 7))
    executors.serve_jobs(end, None)
    (done, none), (nothing, error) = end.answers
    assert (done, none, nothing, type(error)) == ("A", None, None, TypeError)


def test_there_is_no_other_executor() -> None:
    for wrong in ("threads", "dask://", "dask"):
        with pytest.raises(UsageError, match="processes"):
            runner_of(wrong, 1)


def test_a_scheduler_that_is_not_there_is_said_in_words() -> None:
    import dask
    import distributed  # noqa: F401  (its settings are there from then on)

    with dask.config.set({"distributed.comm.timeouts.connect": "200ms"}):
        with pytest.raises(FleetError, match="dask scheduler"):
            DaskRunner("dask://127.0.0.1:9", timeout=1)
        with pytest.raises(FleetError):
            DaskRunner("dask://not a host:x", timeout=1)


@pytest.mark.parametrize(
    ("place", "asked"),
    [("dask://10.0.0.1", "tcp://10.0.0.1:8786"), ("dask://pi:9000", "tcp://pi:9000")],
)
def test_a_scheduler_has_the_port_of_dask_if_none_is_named(monkeypatch, place, asked) -> None:
    seen = []

    def client(address, **_):
        seen.append(address)
        raise OSError

    monkeypatch.setattr("distributed.Client", client)
    with pytest.raises(FleetError):
        DaskRunner(place)
    assert seen == [asked]


def test_without_dask_the_error_says_what_to_install(monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(MissingExtra, match=r"mikas\[dask\]"):
        DaskRunner("dask://127.0.0.1:8786")


class Cluster:
    """A real scheduler, and workers in processes of their own."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.processes = folder, []
        self.env = {**os.environ, "DASK_DISTRIBUTED__WORKER__PRELOAD": "[]"}
        self.env["PYTHONPATH"] = os.pathsep.join(sys.path)
        options = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard")
        said = self.start("scheduler", *options, until="Scheduler at:")
        self.address = said.split("tcp://")[1].split()[0]

    def start(self, what: str, *options: str, until: str) -> str:
        command = [sys.executable, "-m", "dask", what, *options]
        process = subprocess.Popen(
            command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True, env=self.env,
            cwd=self.folder,
        )  # fmt: skip
        self.processes.append(process)
        said = []
        for line in process.stderr:
            said.append(line)
            if until in line:
                threading.Thread(target=process.stderr.read, daemon=True).start()
                return line
        raise RuntimeError("".join(said))

    def worker(self) -> subprocess.Popen:
        options = ("--no-nanny", "--nthreads", "1", "--no-dashboard", "--host", "127.0.0.1")
        self.start("worker", f"tcp://{self.address}", *options, until="Starting established")
        return self.processes[-1]

    def close(self) -> None:
        for process in self.processes:
            with suppress(OSError):
                process.kill()
            process.wait()
            process.stderr.close()


@contextmanager
def cluster(folder: Path) -> Iterator[Cluster]:
    it = Cluster(folder)
    try:
        yield it
    finally:
        it.close()


@pytest.mark.posix
def test_a_cluster_completes_though_one_of_its_workers_is_killed(tmp_path) -> None:
    folder = some(tmp_path / "in", 10)
    with cluster(tmp_path) as it:
        with pytest.raises(FleetError, match="no workers"):
            DaskRunner(f"dask://{it.address}")
        it.worker()
        doomed = it.worker()
        seen = []

        def on_file(outcome) -> None:
            seen.append(outcome)
            if len(seen) == 3:
                doomed.kill()

        result = add_by(DaskRunner(f"dask://{it.address}"), folder, tmp_path / "set", on_file)
        assert counts(result) == (10, 0, 0, 1)
        assert ask(tmp_path / "set", TOTAL) == [(10 * 239, 10)]
        by_one = add_by(ProcessRunner(1), folder, tmp_path / "other")
        assert counts(by_one) == counts(result)
        assert files_of(tmp_path / "set") == files_of(tmp_path / "other")
        for name in files_of(tmp_path / "set"):
            same = (tmp_path / "other" / name).read_bytes()
            assert (tmp_path / "set" / name).read_bytes() == same
        make(folder / "last.pcapng", began=BEGAN - DAY)
        runner = DaskRunner(f"dask://{it.address}")
        it.processes[0].kill()
        with pytest.raises(FleetError, match="gone"):
            add_by(runner, folder, tmp_path / "set")


@pytest.mark.posix
def test_a_scheduler_that_is_killed_amid_the_work_leaves_whole_recordings(
    tmp_path,
) -> None:
    folder = some(tmp_path / "in", 10)
    with cluster(tmp_path) as it:
        it.worker()
        seen = []

        def on_file(outcome) -> None:
            seen.append(outcome)
            if len(seen) == 2:
                it.processes[0].kill()

        with pytest.raises(FleetError, match="gone"):
            add_by(DaskRunner(f"dask://{it.address}"), folder, tmp_path / "set", on_file)
    ((rows, drives),) = ask(tmp_path / "set", TOTAL)
    assert 1 <= drives <= 10
    assert rows == 239 * drives
    assert counts(add_by(ProcessRunner(1), folder, tmp_path / "set"))[0] == 10 - drives
    loggers = [name for name in logging.root.manager.loggerDict if name.startswith("distributed.")]
    assert "distributed.utils" in loggers  # from which a traceback came on the terminal
    assert not any(logging.getLogger(name).isEnabledFor(logging.ERROR) for name in loggers)


def test_a_worker_that_does_not_see_the_dataset_adds_nothing(tmp_path) -> None:
    folder = some(tmp_path / "in", 1)
    files = plan([str(folder / "0.pcapng")], str(tmp_path / "set"), SETTINGS).files
    outcome = work(files[0], str(tmp_path / "on another computer"), SETTINGS)
    assert outcome.ends
    assert outcome.bad is not None
    assert "does not see this dataset" in outcome.bad.en
    assert not (tmp_path / "on another computer").exists()
