"""One session of each drive: its file, the dashboard, MQTT and the command line agree on gaps,
units, faults and counts.
"""

from __future__ import annotations

import io
import json
import re
from contextlib import closing, redirect_stdout
from types import SimpleNamespace

import pytest

from golden.garage_rig import CABLE, DRIVES
from golden.runs_rig import CHANNELS
from mikas.catalog import shipped
from mikas.cli.options.sampling import SamplingOptions
from mikas.cli.render.notices import Notices
from mikas.cli.render.output import Output
from mikas.cli.render.values import json_line
from mikas.client.connecting import ConnectionOptions
from mikas.dashboard.session.history import History, page_json
from mikas.dashboard.session.monitor import ConnectionMonitor
from mikas.link.reconnecting import ReconnectingPort
from mikas.publish.publication import Publication
from mikas.publish.topics import Topics
from mikas.recording.recorder import Recorder
from mikas.recording.recording import Recording
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.events import FaultReading, Gap, Sampled, StateChanged, UnitFound
from mikas.sampling.session import SamplingSession

CATALOG = shipped()
TOPICS = Topics("garage/volga")


class Consumers:
    """All who follow one session."""

    def __init__(self, drive, folder) -> None:
        garage = drive.garage()
        self.recorder = Recorder()
        self.session = SamplingSession(self.recorder.record_event)
        port = ReconnectingPort(
            CABLE.url,
            find=garage.find,
            open_port=garage.open,
            clock=garage.now,
            wait=garage.wait,
            sink=self.recorder,
        )
        acquisition = Acquisition(
            *(port, ConnectionOptions(catalog=CATALOG).create_ecu, CATALOG, CHANNELS),
            method=drive.method,
            rate=5.0,
        )
        self.monitor = ConnectionMonitor(History(), self.session)
        publication = Publication(TOPICS, CATALOG, acquisition.channels, samples=True)
        self.sentences: list[str] = []
        shown = SimpleNamespace(
            options=SamplingOptions(),
            connected=True,
            model=None,
            recorder=self.recorder,
            acquisition=acquisition,
            channels=acquisition.channels,
            later=0.0,
        )
        notices, printed = Notices(shown, self.sentences.append), io.StringIO()
        messages, self.events = [], []
        path = folder / "drive.pcapng"
        self.recorder.start(path, url=CABLE.url)
        self.counts = []  # of each file: samples, gaps
        self.recorder.on_file = lambda _: None
        with closing(self.session.run(acquisition)) as events, redirect_stdout(printed):
            for event in events:
                self.events.append(event)
                self.monitor.add_event(event)
                messages += publication.messages_of(event)
                notices.show_event(event)
                json_line(shown, Output(json=True), event)
                if event.time > drive.seconds + 8:
                    break
        messages += publication.last_messages()
        self.status = self.recorder.stop()
        self.lines = [json.loads(line) for line in printed.getvalue().splitlines()]
        self.published = [(it.topic.rpartition("/")[2], json.loads(it.payload)) for it in messages]
        files = sorted(folder.glob("*.pcapng"), key=lambda it: (len(it.name), it.name))
        self.recordings = [Recording(file, CATALOG) for file in files]

    def of(self, kind):
        return [event for event in self.events if isinstance(event, kind)]

    def recorded(self, kind):
        return [it for file in self.recordings for it in file.events if isinstance(it, kind)]

    def of_page(self, kind):
        return [it for it in map(page_json, self.monitor.logged) if it["kind"] == kind]

    def of_mqtt(self, kind):
        return [it for topic, it in self.published if topic == "event" and it["kind"] == kind]


@pytest.fixture(params=DRIVES, ids=lambda it: it.name, scope="module")
def drive(request, tmp_path_factory):
    return Consumers(request.param, tmp_path_factory.mktemp(request.param.name))


def test_all_have_the_same_gaps(drive):
    gaps = [(it.began, it.ended) for it in drive.of(Gap)]
    assert gaps
    assert [(it["began"], it["ended"]) for it in drive.of_page("gap")] == gaps
    assert [(it["began"], it["ended"]) for it in drive.of_mqtt("gap")] == gaps
    over = [it for it in drive.of(Gap) if it.ended is not None]
    assert [it["reason"] for it in drive.of_mqtt("gap") if it["ended"]] == [
        {"en": it.reason.en, "ru": it.reason.ru} for it in over
    ]
    if len(drive.recordings) == 1:
        recorded = drive.recorded(Gap)
        assert [(it.began, it.ended) for it in recorded] == [(it.began, it.ended) for it in over]
        assert [it.reason for it in recorded] == [it.reason for it in over]
        assert drive.status.gaps == len(recorded)
    else:  # a car's own file each: the gap has a part in both
        before, after = (one.events for one in drive.recordings)
        (first,), (second,) = (
            [it for it in part if isinstance(it, Gap)] for part in (before, after)
        )
        assert [(first.began, second.ended)] == [(it.began, it.ended) for it in over]
        assert first.ended == second.began


def test_the_command_line_tells_of_the_gaps_that_last(drive):
    over = [it for it in drive.of(Gap) if it.ended is not None]
    told = [int(re.findall(r"\d+", it)[0]) for it in drive.sentences if it.startswith("Back after")]
    broken = [it.time for it in drive.of(StateChanged) if it.is_broken]
    lasting = [
        round(it.ended - it.began)
        for it in over
        if it.ended - it.began > 3 or any(it.began < time < it.ended for time in broken)
    ]
    if drive.of(UnitFound)[-1].another:
        assert told == []  # the unit before is not back
    else:
        assert told == lasting
    for gap in over:  # no sample in it, at least one failed cycle
        inside = [
            it["gap"] for it in drive.lines if gap.began + 1e-5 < it["time"] < gap.ended - 1e-5
        ]
        assert inside
        assert all(inside)


def test_all_have_the_same_units_and_faults(drive):
    found = [(it.time, it.another) for it in drive.of(UnitFound)]
    assert [(it["time"], it["another"]) for it in drive.of_page("unit")] == found
    assert [it["another"] for it in drive.of_mqtt("unit")] == [it for _, it in found]
    assert len(drive.recordings) == 1 + sum(another for _, another in found)
    assert sum("Another unit" in it for it in drive.sentences) == len(drive.recordings) - 1
    codes = list(dict.fromkeys(it.codes for it in drive.of(FaultReading)))
    assert list(dict.fromkeys(it.codes for it in drive.recorded(FaultReading))) == codes
    assert list(dict.fromkeys(tuple(it["codes"]) for it in drive.of_mqtt("faults"))) == codes


def test_all_count_the_same_samples(drive):
    samples = len(drive.of(Sampled))
    assert drive.session.samples == samples
    rows = [len(it["samples"]) for topic, it in drive.published if topic == "samples"]
    assert sum(rows) == samples
    assert sum(not it["gap"] for it in drive.lines) == samples
    assert len(drive.monitor.history.rows(1e6).times) == samples
    if len(drive.recordings) == 1:
        assert drive.status.samples == samples
