"""The Debian package: the one-folder program, udev's rules, the icon, what menus show, the manual.

    /usr/lib/mikas                    the program; /usr/bin/mikas leads to it
    /usr/lib/udev/rules.d             the text of `mikas ports --install-rules`
    /usr/share/applications, icons    what menus show
    /usr/share/metainfo               what software centres show (AppStream)
    /usr/share/bash-completion, zsh, fish    completion by the Tab key

It has no maintainer scripts: udev sees its rules, and triggers of Debian's packages see the rest.
"""

from __future__ import annotations

import gzip
import os
import re
import shutil
import subprocess
from datetime import UTC, datetime
from email.utils import format_datetime
from pathlib import Path
from typing import Final

from mikas.cli.completion import script
from mikas.link import udev_rules
from tools.package import manual, program
from tools.package.project import BUILD, DIST, HERE, ICONS, ROOT, project, time_of_source, version

_TREE: Final = BUILD / "deb"
_MAINTAINER: Final = "The mikas authors <mikas-diagnostics@users.noreply.github.com>"
_CONTROL: Final = """\
Package: mikas
Version: {version}
Architecture: {architecture}
Maintainer: {maintainer}
Installed-Size: {kilobytes}
Depends: {depends}
Recommends: xdg-utils
Section: electronics
Priority: optional
Homepage: {homepage}
Description: diagnostics for Mikas 5.4 and 7.1 engine control units
 For cars with these units (GAZ Volga, Gazelle, Sobol; UAZ; engines of the
 ZMZ-406 family), a laptop and a KKL cable: live values, faults, memory,
 recordings and guided tests, on a page in the browser or in a terminal.
 English and Russian.
 .
 The program is whole: it needs no Python and no network. The package lets the
 user at the computer open the cable's port, and keeps ModemManager and brltty
 off it.
"""
_COPYRIGHT: Final = """\
Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: mikas
Source: {homepage}
Comment: The program in /usr/lib/mikas holds Python and other packages. Their
 licences are in /usr/lib/mikas/_internal/notices.txt

Files: *
Copyright: {copyright}
License: Expat
{licence}
"""
_CHANGELOG: Final = """\
mikas ({version}) unstable; urgency=medium

  * Release {version}: {homepage}/releases

 -- {maintainer}  {date}
"""
_COMPLETION: Final = {
    "bash": "bash-completion/completions/mikas",
    "zsh": "zsh/vendor-completions/_mikas",
    "fish": "fish/vendor_completions.d/mikas.fish",
}
_COMPONENT: Final = "io.github.mikas_diagnostics.mikas"
_RELEASE = re.compile(r"(a|b|rc|\.dev)(\d+)$")


def build() -> list[Path]:
    """Build it of the one-folder program that is there."""
    shutil.rmtree(_TREE, ignore_errors=True)
    _fill(_TREE)
    number, architecture = debian_version(version()), _output("dpkg", "--print-architecture")
    used = sum(file.lstat().st_size for file in _TREE.rglob("*") if not file.is_dir())
    control = _CONTROL.format(
        version=number,
        architecture=architecture,
        maintainer=_MAINTAINER,
        kilobytes=used // 1024,
        depends=f"libc6 (>= {least_libc(_TREE)})",
        homepage=_homepage(),
    )
    _write("DEBIAN/control", control)
    DIST.mkdir(exist_ok=True)
    path = DIST / f"mikas_{number}_{architecture}.deb"
    subprocess.run(
        ["dpkg-deb", "--root-owner-group", "-Zxz", "-z1", "--build", str(_TREE), str(path)],
        env={**os.environ, "SOURCE_DATE_EPOCH": str(time_of_source())},
        stdout=subprocess.DEVNULL,
        check=True,
    )
    return [path]


def debian_version(number: str) -> str:
    """Return the version as Debian sorts it: a candidate is before its release."""
    return _RELEASE.sub(r"~\1\2", number)


def least_libc(folder: Path) -> str:
    """Return the version of the C library that the files of `folder` need."""
    versions = {
        tuple(map(int, found.split(".")))
        for file in folder.rglob("*")
        if file.is_file() and not file.is_symlink() and file.read_bytes()[:4] == b"\x7fELF"
        for found in re.findall(
            r"\(GLIBC_(\d+\.\d+(?:\.\d+)?)\)", _output("objdump", "--dynamic-syms", str(file))
        )
    }
    return ".".join(map(str, max(versions)))


def _fill(tree: Path) -> None:
    shutil.copytree(program.folder(), tree / "usr/lib/mikas", symlinks=True)
    (tree / "usr/bin").mkdir()
    (tree / "usr/bin/mikas").symlink_to("../lib/mikas/mikas")
    _write(f"usr/lib/udev/rules.d/{udev_rules.FILE.name}", udev_rules.rules())
    _write(
        "usr/share/applications/mikas.desktop", (HERE / "linux/mikas.desktop").read_text("utf-8")
    )
    for icon in ICONS.glob("*.png"):
        _copy(icon, f"usr/share/icons/hicolor/{icon.stem}x{icon.stem}/apps/mikas.png")
    _copy(ICONS / "mikas.svg", "usr/share/icons/hicolor/scalable/apps/mikas.svg")
    for name, page in manual.files().items():
        _write(f"usr/share/{name}.gz", page)
    for shell, name in _COMPLETION.items():
        _write(f"usr/share/{name}", script(shell))
    _write("usr/share/lintian/overrides/mikas", (HERE / "linux/lintian").read_text("utf-8"))
    _write("usr/share/doc/mikas/copyright", _copyright())
    _write("usr/share/doc/mikas/changelog.gz", _changelog())
    _write(f"usr/share/metainfo/{_COMPONENT}.metainfo.xml", _metainfo())
    for path in tree.rglob("*"):
        if not path.is_symlink():
            runs = path.is_dir() or (path.name == "mikas" and path.parent.name == "mikas")
            path.chmod(0o755 if runs else 0o644)


def _copyright() -> str:
    _, _, licence = (ROOT / "LICENSE").read_text("utf-8").partition("Copyright ")
    holder, _, terms = licence.partition("\n")
    lines = [f" {line}" if line else " ." for line in terms.strip().splitlines()]
    return _COPYRIGHT.format(homepage=_homepage(), copyright=holder, licence="\n".join(lines))


def _changelog() -> str:
    return _CHANGELOG.format(
        version=debian_version(version()),
        homepage=_homepage(),
        maintainer=_MAINTAINER,
        date=format_datetime(_time()),
    )


def _metainfo() -> str:
    text = (HERE / "linux/metainfo.xml").read_text("utf-8")
    pictures = f"{_homepage().replace('github.com', 'raw.githubusercontent.com')}/v{version()}"
    return text.format(
        homepage=_homepage(),
        pictures=f"{pictures}/docs/pictures",
        version=debian_version(version()),
        date=_time().date(),
    )


def _homepage() -> str:
    return str(project()["urls"]["Homepage"])


def _time() -> datetime:
    return datetime.fromtimestamp(time_of_source(), UTC)


def _write(name: str, text: str) -> None:
    path = _TREE / name
    path.parent.mkdir(parents=True, exist_ok=True)
    data = text.encode()
    path.write_bytes(gzip.compress(data, 9, mtime=0) if path.suffix == ".gz" else data)


def _copy(file: Path, name: str) -> None:
    path = _TREE / name
    path.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(file, path)


def _output(*command: str) -> str:
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
