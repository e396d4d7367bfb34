"""A recording of a virtual car with instruments beside it, written as a session writes it."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from mikas.client.connecting import ConnectionOptions
from mikas.instruments import InstrumentDefinition, definition_named
from mikas.live.progress import Length
from mikas.live.starting import prepared
from mikas.recording.capture.instruments import instrument_port
from mikas.recording.recorder import Recorder
from mikas.sampling.events import Sampled

CHANNELS = ("FREQ", "TWAT", "JAIR")
Heard = tuple[int, bytes, float, str]
"""The instrument's number, its bytes, the seconds since the sample before, a comment."""


def record(
    path: Path,
    heard: Iterable[tuple[int, list[Heard]]] = (),
    definitions: Iterable[tuple[InstrumentDefinition | str, str]] = (("aem", ""),),
    *,
    count: int = 40,
    seed: int = 1,
    port: str = "",
) -> Path:
    """Record `count` samples. `heard`: what comes after the sample of a number."""
    ports = [
        instrument_port(
            definition_named(each) if isinstance(each, str) else each, f"/dev/meter{label}", label
        )
        for each, label in definitions
    ]
    recorder = Recorder()
    url = f"sim:?clock=simulated&seed={seed}{port}"
    session = prepared(
        url,
        ConnectionOptions(),
        CHANNELS,
        Length(count, None, None),
        method="batch",
        recorder=recorder,
        wants_faults=lambda: False,
    )
    recorder.instruments = ports
    recorder.start(path, url=url)
    after = dict(heard)
    number = 0

    def hear(sample: Sampled) -> None:
        nonlocal number
        for instrument, data, later, comment in after.get(number, ()):
            recorder.record_instrument(instrument, data, sample.time + later, comment)
        number += 1

    session.on(Sampled, hear)
    with session:
        session.run()
    return path
