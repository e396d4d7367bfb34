"""Recordings of drives with exact figures: the bytes of a unit and of a receiver beside it."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from mikas.catalog import shipped
from mikas.framing import encode
from mikas.instruments import definition_of_text
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.instruments import instrument_port
from mikas.recording.capture.notes import ENTERPRISE, TAG
from mikas.recording.recording import Recording

RECEIVER = definition_of_text(
    "own",
    'text = "Receiver"\ndecoder = "line"\nbaud = 115200\nstale = 2.5\n'
    'patterns = ["{GPS_SPEED} {GPS_LAT} {GPS_LON} {LAMBDA}"]\n',
)
_MICRO = 1_000_000
_BYTE = 10 / 9600
FREQ, RXX, JQT, VALF, THR = 0x29, 0x07, 0x40, 0x39, 0x20


@dataclass
class Unit:
    """What the unit answers at a time. None: the parameter is not requested."""

    time: float
    rpm: int | None = None  # steps of 40
    flow: float | None = None  # steps of 0.1 l/h
    idle: bool | None = None
    aimed: float | None = None  # steps of 1/256
    throttle: int | None = None  # %


@dataclass
class Road:
    """What the receiver says at a time."""

    time: float
    speed: float
    latitude: float = 56.0
    longitude: float = 44.0
    lambda_: float = 1.0


@dataclass
class Session:
    """One session of a recording."""

    unit: Iterable[Unit]
    road: Iterable[Road] = ()
    marks: Iterable[tuple[float, str]] = ()
    begins: float = 0.0
    parts: list[tuple[float, bytes]] = field(default_factory=list)

    def blocks(self) -> bytes:
        for each in self.unit:
            self._answer(each)
        road = list(self.road)
        if road:
            self._hear(max(0.0, road[0].time - 0.5), b"\n")
        for said in road:
            line = f"{said.speed} {said.latitude} {said.longitude} {said.lambda_}\n"
            self._hear(said.time, line.encode())
        for time, label in self.marks:
            note = {"kind": "marker", "time": time, "data": {"label": label}}
            block = pcapng.Custom(ENTERPRISE, TAG + json.dumps(note).encode())
            self.parts.append((time, pcapng.encode(block)))
        ports = pcapng.encode(pcapng.Interface(name="sim:"))
        if road:
            ports += pcapng.encode(instrument_port(RECEIVER, "/dev/receiver"))
        ordered = [data for _, data in sorted(self.parts, key=lambda part: part[0])]
        return pcapng.encode(pcapng.Section(application="mikas")) + ports + b"".join(ordered)

    def _answer(self, said: Unit) -> None:
        asked, data = [], b""
        if said.rpm is not None:
            asked.append(FREQ)
            data += bytes([said.rpm // 40])
        if said.flow is not None:
            asked.append(JQT)
            data += round(said.flow * 10).to_bytes(2, "little")
        if said.idle is not None:
            asked.append(RXX)
            data += bytes([4 if said.idle else 0])
        if said.aimed is not None:
            asked.append(VALF)
            data += bytes([round((said.aimed - 0.5) * 256)])
        if said.throttle is not None:
            asked.append(THR)
            data += bytes([said.throttle])
        for body, begins, flags in (
            (bytes([0x61, *asked]), max(0.0, said.time - 0.01), pcapng.OUTBOUND),
            (data, said.time, pcapng.INBOUND),
        ):
            wire, time = encode(body), begins
            if flags == pcapng.INBOUND:
                time += len(wire) * _BYTE  # it arrives when its last byte has come
            packet = pcapng.EnhancedPacket(0, round(time * _MICRO), wire, flags)
            self.parts.append((time, pcapng.encode(packet)))

    def _hear(self, time: float, line: bytes) -> None:
        packet = pcapng.EnhancedPacket(1, round(time * _MICRO), line, pcapng.INBOUND)
        self.parts.append((time, pcapng.encode(packet)))


def recorded(path: Path, *sessions: Session) -> Recording:
    """Write the sessions, and return the recording of them."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(b"".join(each.blocks() for each in sessions))
    return Recording(path, shipped())
