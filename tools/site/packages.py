"""The program of the site: mikas itself, and the packages that it imports in a browser.

The packages are those of this Python's environment, which requirements/install.py installed by the
hashes of the lock: a file that was changed since is refused. One has code in C or Rust, built for
Pyodide: pip fetches it by the same lock.
"""

from __future__ import annotations

import base64
import hashlib
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from importlib.metadata import Distribution, distribution
from pathlib import Path

from tools.site.archives import files_of

ROOT = Path(__file__).resolve().parents[2]
LOCK = ROOT / "requirements" / "lock.txt"

PURE = (
    "annotated-doc", "annotated-types", "anyio", "fastapi", "jinja2", "markupsafe",
    "opentelemetry-api", "pydantic", "segno", "starlette", "tomlkit", "typing-extensions",
    "typing-inspection",
)  # fmt: skip
BUILT = "pydantic-core"
PLATFORM = "pyemscripten_2026_0_wasm32"
PYTHON = "3.14"

# The lazy importer of this module does not work from bytecode.
STAYS_SOURCE = frozenset({"anyio/__init__.py"})

_UNUSED = (
    "anyio/_backends/_trio.py", "anyio/pytest_plugin.py", "fastapi/__main__.py", "fastapi/cli.py",
    "fastapi/testclient.py", "jinja2/asyncsupport.py", "pydantic/_hypothesis_plugin.py",
    "pydantic/mypy.py", "pydantic/v1/", "starlette/testclient.py",
)  # fmt: skip
# OpenTelemetry's interface finds its parts by the entry points of its own distribution.
_WITH_METADATA = frozenset({"opentelemetry-api"})
_METADATA = frozenset({"METADATA", "entry_points.txt"})

# What works in a browser of pyproject.toml's links, and the link of the site alone.
_LINKS = ("sim", "replay")
_OWN_LINKS = dict.fromkeys(("webserial", "webusb"), "mikas.browser.web_serial:open_web_serial")
# The command line and what it alone calls, the server and its page, what shows and draws the
# recording of `mikas.open`, links and formats of libraries that are not here, what tests by pytest,
# and what computes with arrays of bytes by numpy, in place of which there is a loop.
_NOT_HERE = (
    "amendments", "cli", "__main__.py", "conditions/messages.py",
    "conditions/webhooks.py", "py.typed",
    "dashboard/page", "dashboard/running.py", "foreign_logs/mdf.py",
    "dashboard/server.py", "dissectors", "fleet", "link/failures.py", "link/network.py",
    "link/serial.py", "publish", "recording/export/mdf.py", "recording/export/parquet.py",
    "recording/instrument_lines.py",
    "recording/parquet.py", "replay/routine.py", "testing",
    "virtual/met_unit.py", "virtual/profiles", "virtual/unit_files.py",
    "virtual/unit_profile.py",
    *(f"recording/exchanges/columns/{each}.py" for each in (
        "directions", "frames", "matcher", "packets", "turn_runs",
    )),
    *(f"notebook/{each}.py" for each in (
        "drawing", "html", "interruptions", "overview", "panes", "picture", "text", "time_axis",
        "value_axes", "wording",
    )),
)  # fmt: skip

# Asks for numpy, and is asked whether it can be had.
ASKS_FOR_NUMPY = "mikas.recording.exchanges.columns.pieces"


class Changed(Exception):
    """A file of an installed package is not the one that was installed."""


def third_party() -> dict[str, bytes]:
    """Return the sources of the pure packages, by their paths in site-packages."""
    return {name: content for each in PURE for name, content in _of(distribution(each))}


def built(folder: Path) -> dict[str, bytes]:
    """Return the files of the package that is built for Pyodide; its wheel is kept in `folder`."""
    wheels = folder / f"{BUILT}-{distribution(BUILT).version}"
    if not any(wheels.glob("*.whl")):
        subprocess.run(
            [
                sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check",
                "--no-deps", "--only-binary=:all:", "--require-hashes",
                f"--constraint={LOCK}", f"--dest={wheels}", f"--python-version={PYTHON}",
                "--implementation=cp", f"--abi=cp{PYTHON.replace('.', '')}",
                f"--platform={PLATFORM}", BUILT,
            ],
            check=True,
        )  # fmt: skip
    (wheel,) = wheels.glob("*.whl")
    files = files_of(wheel.read_bytes())
    return {
        name: content
        for name, content in files.items()
        if name.endswith((".py", ".so")) and ".dist-info/" not in name
    }


def own() -> dict[str, bytes]:
    """Return mikas' modules and data, by their paths in site-packages, and its metadata."""
    package = ROOT / "src" / "mikas"
    found: dict[str, bytes] = {}
    for path in sorted(package.rglob("*")):
        name = path.relative_to(package).as_posix()
        left_out = any(name == each or name.startswith(f"{each}/") for each in _NOT_HERE)
        if path.is_file() and not left_out and "__pycache__" not in path.parts:
            found[f"mikas/{name}"] = path.read_bytes()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    links = project["entry-points"]["mikas.links"]
    entries = {name: links[name] for name in _LINKS} | _OWN_LINKS
    lines = ["[mikas.links]", *(f"{name} = {where}" for name, where in entries.items()), ""]
    metadata = f"Metadata-Version: 2.1\nName: mikas\nVersion: {project['version']}\n"
    folder = f"mikas-{project['version']}.dist-info"
    found[f"{folder}/METADATA"] = metadata.encode()
    found[f"{folder}/entry_points.txt"] = "\n".join(lines).encode()
    return found


def _of(installed: Distribution) -> Iterator[tuple[str, bytes]]:
    for file in installed.files or ():
        name = file.as_posix()
        folder, _, last = name.rpartition("/")
        metadata = folder.endswith(".dist-info")
        if metadata:
            wanted = installed.name in _WITH_METADATA and last in _METADATA
        else:
            wanted = name.endswith(".py") and not name.startswith((*_UNUSED, ".."))
        if not wanted:
            continue
        content = Path(str(installed.locate_file(file))).read_bytes()
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=")
        if file.hash is None or file.hash.value != digest.decode():
            raise Changed(f"{name} of {installed.name} was changed after it was installed")
        yield name, content
