"""python -m tools.package.trial PROGRAM: tries a program as whoever has just installed it would.

`prefix`: what comes before each command line, to run it on another computer (tests/installing).
"""

from __future__ import annotations

import json
import plistlib
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from tools.package.project import version

FORMATS: Final = ("csv", "mf4", "parquet", "msl", "mlg")
_CAR: Final = ("--port", "sim:?clock=simulated")
# As a browser does: the page, and all that it names.
_FETCH: Final = """
import json, re, sys, urllib.request
def get(url):
    with urllib.request.urlopen(url, timeout=60) as answer:
        return [answer.headers.get_content_type(), answer.read()]
url = sys.argv[1]
kind, page = get(url)
found = {"": [kind, len(page)]}
for name in re.findall(r'(?:src|href)="[.]?/?([^"#:]+)"', page.decode()):
    kind, content = get(url + name)
    found[name] = [kind, len(content)]
print(json.dumps(found))
"""


class Wrong(Exception):
    """The program does not do what it has to."""


@dataclass(frozen=True, slots=True)
class Trial:
    """`folder`: for recordings. Each check raises `Wrong`."""

    program: Path
    folder: Path
    prefix: Sequence[str] = ()

    def everything(self) -> None:
        """Do all that a program with all formats has to do."""
        self.is_an_application()
        self.begins()
        self.shows_its_page()
        self.records_and_exports(FORMATS)
        self.adds_to_a_fleet()

    def is_an_application(self) -> None:
        """Find what a double click starts, if the program is that of a folder `.app` (macOS)."""
        application = self.program.parents[2]
        if application.suffix != ".app":
            return
        facts = plistlib.loads((application / "Contents" / "Info.plist").read_bytes())
        started = self.program.with_name(facts["CFBundleExecutable"])
        self._holds(started.stem == "mikas-dashboard", f"a double click starts {started.name}")
        self._holds(started.is_file(), f"no {started.name}")

    def begins(self) -> None:
        """Ask for the version, the help in both languages, parameters, ports, decoders, a value."""
        self._holds(self.run("--version").strip() == f"mikas {version()}", "--version")
        self._holds("Diagnostics for" in self.run("--help", "--lang", "en"), "--help")
        self._holds("Диагностика блоков" in self.run("--help", "--lang", "ru"), "--help --lang ru")
        self._holds(len(self.answer("params")["parameters"]) > 20, "params")
        self._holds(isinstance(self.answer("ports")["ports"], list), "ports")
        self._holds("complete" in self.run("completion", "bash"), "completion")
        for decoder in ("wireshark", "sigrok"):
            self._holds("CREADP" in self.answer(decoder)["text"], decoder)
        value = self.answer("read", "TWAT", *_CAR)["readings"]["TWAT"]
        self._holds(value["unit"] == "°C", "read")

    def shows_its_page(self) -> None:
        """Get the page and its assets, of `demo` and of `dash`."""
        for words in (("demo", "--scenario", "warm-idle"), ("dash",)):
            with self.dashboard(*words) as url:
                fetched = self._output(sys.executable, "-c", _FETCH, url)
            page: dict[str, tuple[str, int]] = json.loads(fetched)
            kinds = dict(page.values())
            wanted = {"text/html", "text/javascript", "text/css", "image/svg+xml"}
            self._holds(wanted <= set(kinds), f"{words[0]}: {page}")
            self._holds(kinds["text/javascript"] > 100_000, f"{words[0]}: {page}")

    def records_and_exports(self, formats: Sequence[str]) -> None:
        """Record a drive, export it in all `formats`, make a report of it."""
        tape = self.folder / "drive.pcapng"
        self.run("log", "-o", str(tape), "--count", "50", *_CAR)
        for suffix in formats:
            out = self.folder / f"drive.{suffix}"
            rows = self.answer("export", str(tape), "-o", str(out))["rows"]
            self._holds(rows >= 50 and out.stat().st_size > 1000, f"export to .{suffix}")
        page = self.folder / "car.html"
        self.run("report", str(tape), "-o", str(page))
        self._holds("<html" in page.read_text("utf-8"), "report")

    def adds_to_a_fleet(self) -> None:
        """Add the recordings there to a dataset, by processes, which are this program again."""
        dataset = self.folder / "dataset"
        added = self.answer(
            "fleet", "add", str(self.folder), "--to", str(dataset), "--workers", "2"
        )
        self._holds(added["added"] == 1 and not added["bad"], f"fleet add: {added}")
        self._holds(any(dataset.rglob("*.parquet")), "fleet add: no Parquet")

    def run(self, *words: str) -> str:
        """Run a command of the program; return its output."""
        return self._output(str(self.program), *words)

    def answer(self, *words: str) -> dict[str, Any]:
        """Run a command with `--json`; return its object."""
        found: dict[str, Any] = json.loads(self.run(*words, "--json"))
        return found

    @contextmanager
    def dashboard(self, *words: str) -> Iterator[str]:
        """Start a dashboard; its address."""
        running = subprocess.Popen(
            [*self.prefix, str(self.program), *words, "--no-browser", "--json"],
            stdout=subprocess.PIPE,
            stdin=subprocess.DEVNULL,
        )
        assert running.stdout is not None
        try:
            yield json.loads(running.stdout.readline())["url"]
        finally:
            running.terminate()
            running.communicate()

    def _output(self, *command: str) -> str:
        done = subprocess.run(
            [*self.prefix, *command],
            capture_output=True,
            encoding="utf-8",
            stdin=subprocess.DEVNULL,
            check=False,
        )
        said = f"{' '.join(command[:3])}\n{done.stdout}{done.stderr}"
        self._holds(done.returncode == 0, f"status {done.returncode}: {said}")
        return done.stdout

    @staticmethod
    def _holds(condition: bool, what: str) -> None:
        if not condition:
            raise Wrong(what)


def main() -> int:
    """Try the program that the command line names; return the exit status."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            Trial(Path(sys.argv[1]).resolve(), Path(folder)).everything()
        except Wrong as wrong:
            print(f"{sys.argv[1]}: {wrong}", file=sys.stderr)
            return 1
    print(f"{sys.argv[1]}: works")
    return 0


if __name__ == "__main__":
    sys.exit(main())
