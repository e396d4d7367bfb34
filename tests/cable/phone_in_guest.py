"""Chromium inside the box: WebUSB over a real kernel, with and without the kernel's own drivers.

    python -m cable.phone_in_guest [--processors N] [RUN …]

The models behind `usb_sockets_rig` have to act as a kernel does: this compares them with one. In
the box Chromium opens a chip of each kind by the page's own drivers (`phone_page.js`): with the
kernel's driver bound, where a browser that may detach takes FTDI's and CDC-ACM's chips from it and
no other; and without it, as on most phones. The words of a refusal are the program's. The whole
site is too heavy for an emulated computer: it does not start in ten minutes. Three minutes for each
run; each night, not with the tests. Pictures are in `build/phone-in-guest`.
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
HERE = Path(__file__).parent
ROLLDOWN = REPOSITORY / "web" / "node_modules" / ".bin" / "rolldown"
PORT = 8000
EXCHANGE = bytes.fromhex("61 29 76 0D  15 EB 0D")
"""The echo of a request of FREQ, and the response of `still.toml`'s car: 840 rpm."""
CHIPS = (*FOUR, "CH343")
DETACHES = "--enable-features=AutomaticUsbDetach"  # as Chrome on Android does by itself
DETACHED = {"ftdi_sio", "cdc_acm"}
DRIVERS = ("ftdi_sio", "ch341", "cp210x", "pl2303", "cdc_acm")
_PAGE = """<!doctype html>
<meta charset=utf-8>
<link rel=icon href=data:,>
<style>body { font: 15px/1.4 sans-serif; margin: 16px } b { font-size: 18px }</style>
<body><script type=module src=page.js></script>
"""
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
    """`bound`: whether the kernel has its drivers; `flags`: of Chromium."""

    bound: bool
    flags: tuple[str, ...]

    def opens(self, chip: str) -> bool:
        """Return whether the page can take this chip."""
        return not self.bound or (DETACHES in self.flags and driver_of(chip) in DETACHED)


RUNS = {
    "detaching": Run(True, (DETACHES,)),
    "bound": Run(True, ()),
    "unbound": Run(False, (DETACHES,)),
}
"""In this order: what was unloaded stays so."""


Ids = tuple[int, int]


def ids_of(cable: Cable) -> Ids:
    assert cable.chip
    return cable.chip.identity.vid, cable.chip.identity.pid


def ids(said: dict) -> Ids:
    return said["ids"]["usbVendorId"], said["ids"]["usbProductId"]


def bundle(folder: Path) -> None:
    """Write the page of the drivers into `folder`."""
    folder.mkdir()
    (folder / "index.html").write_text(_PAGE, "ascii")
    command = [ROLLDOWN, HERE / "phone_page.js", "--format", "esm", "--file", folder / "page.js"]
    subprocess.run(command, check=True, capture_output=True)


def mistakes_of(box: Box, name: str) -> Iterator[str]:
    """Do the run of this name, and yield what is wrong."""
    run = RUNS[name]
    if not run.bound:
        box.run("busybox", "rmmod", *DRIVERS)  # those that are loaded
    cables = {chip: box.cable(number, chip=chip) for number, chip in enumerate(CHIPS)}
    for number, cable in enumerate(cables.values(), 1):
        cable.put_in()
        box.run("sh", "-c", f"until [ -e /sys/bus/usb/devices/1-{number}:1.0 ]; do sleep 0.1; done")
    of = {ids(it): it for it in _said(box, name, set(map(ids_of, cables.values())))}
    for chip, cable in cables.items():
        yield from _mistakes(chip, of.get(ids_of(cable)), run.opens(chip))
    box.unplug_cables()


def _said(box: Box, name: str, plugged: set[Ids]) -> Iterator[dict]:
    """Yield what the page says of each adapter."""
    vendors = [{"vendor_id": vendor} for vendor, _ in plugged]
    rule = {"devices": vendors, "urls": [f"http://localhost:{PORT}"]}
    policy = json.dumps({"WebUsbAllowDevicesForUrls": [rule]})
    words = [HERE / "phone_serving.py", FOLDER / "page", PORT, installed(), FOLDER / name]
    source = f"PYTHONPATH={REPOSITORY / 'src'}"
    words = ["env", source, sys.executable, *map(str, words), *RUNS[name].flags]
    command = box.start("sh", "-c", _START, "sh", policy, *words)
    for line in command.lines():
        print(f"  {line}", flush=True)
        if line.startswith("{") and "ids" in (said := json.loads(line)):
            yield said
    print(command.wait().err[-2000:], end="", flush=True)


def _mistakes(chip: str, it: dict | None, opens: bool) -> Iterator[str]:
    """Yield what is wrong in what the page says of a chip, which it `opens` or not."""
    if it is None:
        yield f"{chip}: not listed"
    elif opens:
        if any(bytes(it.get(when, ())) != EXCHANGE for when in ("got", "again")):
            yield f"{chip}: not read: {it}"
    elif it.get("failed", [""])[0] != "ClaimError":
        yield f"{chip}: not refused: {it}"
    else:
        other = () if chip == "FT232R" else ("A cable with an FT232R will do",)
        for words in (f"the cable's {it['chip']} is in use", *other):
            if words not in it["en"]:
                yield f"{chip}: {words!r} is not said: {it}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("runs", nargs="*", metavar="RUN", help=f"of {', '.join(RUNS)}; none: all")
    parser.add_argument("--processors", type=int, default=2, help="of the guest")
    wishes = parser.parse_args()
    wanted = [name for name in RUNS if name in (wishes.runs or RUNS)]
    if reason := missing() or ("" if installed() else "Chromium is not installed"):
        sys.exit(reason)
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
