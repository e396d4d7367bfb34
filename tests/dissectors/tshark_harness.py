"""tshark with the dissector: what it shows of a capture, in the form of `mikas decode --json`."""

from __future__ import annotations

import json
import os
import subprocess
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path

TSHARK = "tshark"
_HEX = ("body", "wire", "request", "damage.data")


@dataclass
class Shown:
    """A packet. `port`: its name in the first section, elsewhere empty. `items`: frames and
    damage, each a list of (field, text); `about`: the others.
    """

    number: int
    time: float
    recording: int
    port: str
    items: list[list[tuple[str, str]]] = field(default_factory=list)
    about: dict[str, str] = field(default_factory=dict)


def environment(home: Path) -> dict[str, str]:
    """Return what makes tshark use the plugins and preferences in `home` only."""
    kept = {name: os.environ[name] for name in ("PATH", "LANG") if name in os.environ}
    return {**kept, "HOME": str(home), "TZ": "UTC"}


def run(home: Path, *arguments: str, check: bool = True) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [TSHARK, *arguments],
        check=check,
        capture_output=True,
        encoding="utf-8",
        env=environment(home),
        timeout=300,
    )


def shown(capture: Path, script: Path, *more: str, check: bool = True) -> list[Shown]:
    """Return the packets of the line as `-T json` gives them."""
    chosen = ("-T", "json", "-J", "frame mikas", "-Y", "mikas")
    arguments = ("-X", f"lua_script:{script}", "-r", str(capture), *chosen, *more)
    result = run(script.parent, *arguments, check=check)
    assert "Lua" not in result.stderr, result.stderr
    assert "Lua Error" not in result.stdout, result.stdout
    packets = json.loads(result.stdout, object_pairs_hook=list)
    return [_packet(dict(dict(packet)["_source"])["layers"]) for packet in packets]


def _packet(layers: list) -> Shown:
    about, mikas = dict(layers)["frame"], dict(layers)["mikas"]
    known = dict(about) | dict(dict(about)["frame.interface_id_tree"])
    packet = Shown(
        int(known["frame.number"]),
        _time(known["frame.time_epoch"]),
        recording := int(known["frame.section_number"]) - 1,
        # Wireshark 4.0 takes the names of later sections' ports from the first one.
        "" if recording else known["frame.interface_name"],
    )
    for name, value in mikas if isinstance(mikas, list) else ():  # a text: nothing is below it
        if name == "mikas.frame_tree":
            packet.items.append(list(_flat(value)))
        elif name != "mikas.frame":
            packet.about[name.removeprefix("mikas.")] = value
    return packet


def _time(text: str) -> float:
    """Return seconds since 1970; from Wireshark 4.6 on they are printed as a date."""
    if not text.endswith("Z"):
        return float(text)
    date, _, fraction = text.removesuffix("Z").partition(".")
    seconds = datetime.fromisoformat(f"{date}+00:00").timestamp()
    return round(seconds + float(f"0.{fraction}"), 6)


def _flat(pairs: list):
    for name, value in pairs:
        if name.startswith("mikas."):
            yield name.removeprefix("mikas."), value


def as_decoded(packet: Shown, item: list[tuple[str, str]], times: dict[int, float]) -> dict:
    """Return an item as a line of `mikas decode --json`, without `offset` and Russian."""
    known = dict(item)
    for name in _HEX:
        if name in known:
            known[name] = known[name].replace(":", "").replace(" ", "").upper()
    begin = int(known.get("begin", packet.number))
    end = int(known.get("end", packet.number))
    line = {
        "type": "damage" if "damage" in known else "frame",
        "recording": packet.recording,
        "port": packet.port,
        "time": times[begin],
        "end": times[end],
        "direction": known["direction"],
        "echo": "echo" in known,
    }
    if "damage" in known:
        return line | {"reason": known["damage"], "data": known["damage.data"]}
    return line | {
        "body": known.get("body", ""),
        "wire": known["wire"],
        "raw_checksum": "raw_checksum" in known,
        "irregular": "irregular" in known,
        "name": known.get("name"),
        "request": known.get("request"),
        "meaning": known.get("meaning"),
        "doubt": known.get("doubt"),
    }


def decoded(packets: list[Shown]) -> list[dict]:
    times = {packet.number: packet.time for packet in packets}
    return [as_decoded(packet, item, times) for packet in packets for item in packet.items]
