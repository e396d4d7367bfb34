"""What the guest boots: Debian's kernel, some of its modules with those they need, and busybox.

The initramfs is only the way to the host's files: it loads the modules, mounts the host's root
read-only through 9p, changes into it and starts `guest_agent.py`, so every path in the guest is
the same as on the host. One folder, `shared`, can be written from both sides; what the guest writes
to /etc stays in its memory.
"""

from __future__ import annotations

import lzma
import os
import re
import shutil
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
DOWNLOADED = REPOSITORY / "build" / "cable"
"""Where `make cable` unpacks Debian's kernel and udev; nothing is installed for them."""
QEMU = "qemu-system-x86_64"
MODULES = (
    "virtio_pci", "virtio_console", "9pnet_virtio", "9p", "overlay", "usbcore", "xhci-pci",
    "usbserial", "ftdi_sio", "ch341", "cp210x", "pl2303", "cdc-acm",
)  # fmt: skip
_XZ = b"\xfd7zXZ\0"
_INIT = """#!/bin/busybox sh
set -e
busybox mount -t proc proc /proc
for module in {modules}; do
  busybox insmod /modules/$module.ko
done
options=trans=virtio,version=9p2000.L,msize=262144
busybox mount -t 9p -o $options,ro,cache=loose host /host
busybox mount -t proc proc /host/proc
busybox mount -t sysfs sysfs /host/sys
busybox mount -t devtmpfs dev /host/dev
busybox mount -t tmpfs run /host/run
busybox mount -t 9p -o $options shared "/host{shared}"
busybox mkdir /host/run/etc /host/run/work
busybox mount -t overlay -o lowerdir=/host/etc,upperdir=/host/run/etc,workdir=/host/run/work etc \
  /host/etc
export PYTHONPATH="{repository}/src" PYTHONDONTWRITEBYTECODE=1 LANG=C.UTF-8
exec busybox chroot /host "{python}" "{agent}"
"""


@dataclass(frozen=True, slots=True)
class Kernel:
    """A kernel that can be read: its image, and the files of its modules by name."""

    image: Path
    modules: dict[str, Path]

    def unpacked(self) -> bytes:
        """Return the image to boot: under emulation the kernel takes ten seconds to unpack itself.

        An image that is packed otherwise is returned as it is.
        """
        image = self.image.read_bytes()
        start = image.find(_XZ)
        return image if start < 0 else lzma.LZMADecompressor().decompress(image[start:])


def find_kernel() -> Kernel | None:
    """Return the downloaded kernel, or else an installed one with all the modules."""
    for root in (DOWNLOADED, Path("/")):
        for image in sorted((root / "boot").glob("vmlinuz-*"), reverse=True):
            folder = root / "lib" / "modules" / image.name.removeprefix("vmlinuz-")
            files = (it for it in folder.glob("kernel/**/*") if it.suffix in {".ko", ".xz"})
            found = {_name(path): path for path in files}
            if os.access(image, os.R_OK) and {_normal(it) for it in MODULES} <= found.keys():
                return Kernel(image, found)
    return None


def find_udev() -> tuple[Path, Path] | None:
    """Return `udevadm` and the folder of systemd's own rules: downloaded, or else installed."""
    for root in (DOWNLOADED, Path("/")):
        programs = [it for it in (root / "bin/udevadm", root / "usr/bin/udevadm") if it.exists()]
        folders = [root / "usr/lib/udev/rules.d", root / "lib/udev/rules.d"]
        for rules in folders:
            if programs and (rules / "50-udev-default.rules").exists():
                return programs[0], rules
    return None


def missing() -> str:
    """Return what is missing and which package has it; empty if the box can be built."""
    busybox = shutil.which("busybox")
    reasons = []
    if shutil.which(QEMU) is None:
        reasons.append("no QEMU: apt-get install qemu-system-x86")
    if busybox is None or b"/ld-linux" in Path(busybox).read_bytes():  # the guest has no libc
        reasons.append("no static busybox: apt-get install busybox-static")
    if find_kernel() is None or find_udev() is None:
        reasons.append(
            f"no kernel with {', '.join(MODULES)}, or no udev: `make cable` downloads both with "
            f"apt-get into {DOWNLOADED}, after `apt-get update`"
        )
    return "; ".join(reasons)


def initramfs(kernel: Kernel, shared: Path) -> bytes:
    """Return the archive that boots into `guest_agent.py`."""
    modules = list(_with_needed(kernel))
    init = _INIT.format(
        modules=" ".join(modules),
        shared=shared,
        repository=REPOSITORY,
        python=sys.executable,
        agent=Path(__file__).with_name("guest_agent.py"),
    )
    files = {
        "init": init.encode(),
        "bin/busybox": Path(str(shutil.which("busybox"))).read_bytes(),
        **{f"modules/{name}.ko": _plain(kernel.modules[name]) for name in modules},
    }
    return _archive(("bin", "modules", "proc", "host", "dev"), files)


def _with_needed(kernel: Kernel) -> Iterator[str]:
    """Yield the names of `MODULES` and of all that they need, in the order of loading."""
    yielded = set()

    def load(name: str) -> Iterator[str]:
        if name in yielded or name not in kernel.modules:  # the latter is part of the kernel
            return
        yielded.add(name)
        depends = re.search(rb"\0depends=([^\0]*)\0", _plain(kernel.modules[name]))
        for needed in depends[1].decode().split(",") if depends else ():
            yield from load(_normal(needed))
        yield name

    for name in MODULES:
        yield from load(_normal(name))


def _name(path: Path) -> str:
    return _normal(path.name.partition(".ko")[0])


def _normal(module: str) -> str:
    return module.replace("-", "_")


def _plain(module: Path) -> bytes:
    data = module.read_bytes()
    return lzma.decompress(data) if module.suffix == ".xz" else data


def _archive(folders: tuple[str, ...], files: dict[str, bytes]) -> bytes:
    """Return a cpio archive in the form that the kernel reads ("newc")."""
    archive = bytearray()

    def pad() -> None:
        archive.extend(bytes(-len(archive) % 4))

    def add(name: str, mode: int, data: bytes = b"") -> None:
        path = name.encode() + b"\0"
        fields = (0, mode, 0, 0, 1, 0, len(data), 0, 0, 0, 0, len(path), 0)
        archive.extend(b"070701" + b"".join(b"%08X" % field for field in fields) + path)
        pad()
        archive.extend(data)
        pad()

    for folder in folders:
        add(folder, 0o040755)
    for name, data in files.items():
        add(name, 0o100755, data)
    add("TRAILER!!!", 0)
    return bytes(archive)
