"""Chromium inside the box: WebUSB over a real kernel, with and without the kernel's own drivers.

    python -m cable.phone_in_guest [--processors N] [RUN …]

The models behind `usb_sockets_rig` have to act as a kernel does: this compares them with one. In
the box Chromium opens a chip of each kind by the page's own drivers (`phone_page.js`): with the
kernel's driver bound, where a browser that may detach takes FTDI's and CDC-ACM's chips from it and
no other; and without it, as on most phones. Then the built site does so as a person would
(`phone_site.py`), where what it says of a refused cable is read, too, and pictures are taken into
`build/phone-in-guest`. Minutes for each; run each night, not with the tests.
"""

from __future__ import annotations

import argparse
import compileall
import json
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from browser.chromium_rig import installed
from cable.box_rig import Box, Cable
from cable.image_rig import REPOSITORY, missing
from usb.chips.named import FOUR, driver_of

FOLDER = REPOSITORY / "build" / "phone-in-guest"
SITE = REPOSITORY / "build" / "site"
HERE = Path(__file__).parent
ROLLDOWN = REPOSITORY / "web" / "node_modules" / ".bin" / "rolldown"
PORT = 8000
EXCHANGE = bytes.fromhex("61 29 76 0D  15 EB 0D")
"""The echo of a request of FREQ, and the response of `still.toml`'s car: 840 rpm."""
TWAT = "87"
CHIPS = (*FOUR, "CH343")
DETACHES = "--enable-features=AutomaticUsbDetach"  # as Chrome on Android does by itself
DETACHED = {"ftdi_sio", "cdc_acm"}
DRIVERS = ("ftdi_sio", "ch341", "cp210x", "pl2303", "cdc_acm")
_START = """
ip link set lo up 2>/dev/null || busybox ip link set lo up
mkdir -p /dev/shm /run/p /run/udev/data /etc/chromium/policies/managed
mountpoint -q /dev/shm || mount -t tmpfs shm /dev/shm
touch /run/udev/control
for it in /sys/bus/usb/devices/*/dev; do
  printf 'I:1\\n' > /run/udev/data/c$(cat $it)
done
printf '%s' "$1" > /etc/chromium/policies/managed/usb.json
shift
export HOME=/run/p TMPDIR=/run/p XDG_RUNTIME_DIR=/run/p DBUS_SESSION_BUS_ADDRESS=disabled:
export SYSTEMD_DEVICE_VERIFY_SYSFS=0
"$@"
rm -rf /run/p/profile
"""
"""What a browser needs of a computer; then the command after the policy."""


@dataclass(frozen=True, slots=True)
class Run:
    """`bound`: whether the kernel has its drivers; `flags`: of Chromium; `chips`: plugged in."""

    bound: bool
    flags: tuple[str, ...]
    chips: tuple[str, ...] = CHIPS
    is_site: bool = False

    def opens(self, chip: str) -> bool:
        """Return whether the page can take this chip."""
        return not self.bound or (DETACHES in self.flags and driver_of(chip) in DETACHED)


RUNS = {
    "detaching": Run(True, (DETACHES,)),
    "bound": Run(True, ()),
    "site-detaching": Run(True, (DETACHES,), ("FT232R",), is_site=True),
    "site-refused": Run(True, (DETACHES,), ("CH340",), is_site=True),
    "unbound": Run(False, (DETACHES,)),
    "site-unbound": Run(False, (DETACHES,), ("CH340",), is_site=True),
}
"""In this order: what was unloaded stays so."""


Ids = tuple[int, int]


def ids_of(cable: Cable) -> Ids:
    assert cable.chip
    return cable.chip.identity.vid, cable.chip.identity.pid


def bundle(folder: Path) -> None:
    """Write the page of the drivers into `folder`."""
    folder.mkdir()
    page = (
        "<!doctype html><link rel=icon href=data:,><body><script type=module src=page.js></script>"
    )
    (folder / "index.html").write_text(page, "ascii")
    command = [ROLLDOWN, HERE / "phone_page.js", "--format", "esm", "--file", folder / "page.js"]
    subprocess.run(command, check=True, capture_output=True)


def mistakes_of(box: Box, name: str) -> Iterator[str]:
    """Do the run of this name, and yield what is wrong."""
    run = RUNS[name]
    if not run.bound:
        box.run("busybox", "rmmod", *DRIVERS)  # those that are loaded
    cables = {chip: box.cable(number, chip=chip) for number, chip in enumerate(run.chips)}
    for number, cable in enumerate(cables.values(), 1):
        cable.put_in()
        box.run("sh", "-c", f"until [ -e /sys/bus/usb/devices/1-{number}:1.0 ]; do sleep 0.1; done")
    found = list(_said(box, name, run, cables))
    kinds = {ids_of(cable): chip for chip, cable in cables.items()}
    box.unplug_cables()
    yield from site_mistakes(run, found) if run.is_site else page_mistakes(run, found, kinds)


def _said(box: Box, name: str, run: Run, cables: dict[str, Cable]) -> Iterator[dict]:
    """Yield what the page says, in JSON."""
    vendors = {vendor for vendor, _ in map(ids_of, cables.values())}
    rule = {"devices": [{"vendor_id": it} for it in vendors], "urls": [f"http://localhost:{PORT}"]}
    policy = json.dumps({"WebUsbAllowDevicesForUrls": [rule]})
    if run.is_site:
        pictures = FOLDER / name
        pictures.mkdir(exist_ok=True)
        words = [HERE / "phone_site.py", installed(), SITE, pictures]
    else:
        words = [HERE / "phone_serving.py", FOLDER / "page", PORT, installed()]
    words = [sys.executable, *map(str, words), *run.flags]
    command = box.start("sh", "-c", _START, "sh", policy, *words)
    for line in command.lines():
        print(f"  {line}", flush=True)
        if line.startswith("{"):
            yield json.loads(line)
    print(command.wait().err[-2000:], end="", flush=True)


def page_mistakes(run: Run, found: list[dict], kinds: dict[Ids, str]) -> Iterator[str]:
    """Yield what is wrong in what the page of the drivers says, an object for each chip."""
    of = {(it["ids"]["usbVendorId"], it["ids"]["usbProductId"]): it for it in found if "ids" in it}
    for ids, chip in kinds.items():
        it = of.get(ids)
        if it is None:
            yield f"{chip}: not listed"
        elif run.opens(chip):
            for when in ("got", "again"):
                if bytes(it.get(when, ())) != EXCHANGE:
                    yield f"{chip}: {when}: {it}"
        elif not it.get("failed", "").startswith("ClaimError"):
            yield f"{chip}: not refused: {it}"


def site_mistakes(run: Run, found: list[dict]) -> Iterator[str]:
    """Yield what is wrong in what the site says of its one cable."""
    (chip,) = run.chips
    if not found:
        yield f"{chip}: the site says nothing"
        return
    (it,) = found
    if run.opens(chip):
        if (it["line"], it.get("value")) != ("sampling", TWAT):
            yield f"{chip}: {it['line']}, {it.get('value')}: {it['says']}"
        return
    for words in (f"the cable's {chip} is in use", "A cable with an FT232R will do"):
        if words not in it["says"]:
            yield f"{chip}: {words!r} is not said: {it['says']}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("runs", nargs="*", metavar="RUN", help=f"of {', '.join(RUNS)}; none: all")
    parser.add_argument("--processors", type=int, default=2, help="of the guest")
    wishes = parser.parse_args()
    wanted = [name for name in RUNS if name in (wishes.runs or RUNS)]
    if reason := missing() or ("" if installed() else "Chromium is not installed"):
        sys.exit(reason)
    if any(RUNS[it].is_site for it in wanted) and not (SITE / "files.json").is_file():
        sys.exit("the site was not built: make site")
    compileall.compile_dir(REPOSITORY / "src", quiet=1)  # the guest can't write there
    shutil.rmtree(FOLDER, ignore_errors=True)
    FOLDER.mkdir(parents=True)
    bundle(FOLDER / "page")
    many = wishes.processors
    accel = "tcg,thread=multi" if many > 1 else "tcg"
    hardware = ("-accel", accel, "-smp", str(many), "-m", "2048")
    box = Box(FOLDER, hardware=hardware, sockets=len(CHIPS))
    wrong = 0
    try:
        for name in wanted:
            print(f"{name}: {RUNS[name]}", flush=True)
            for mistake in mistakes_of(box, name):
                wrong += 1
                print(f"MISTAKE: {mistake}", flush=True)
    finally:
        box.close()
    print("no mistake" if not wrong else f"mistakes: {wrong}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
