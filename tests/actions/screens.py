"""All that a person does on the screens, in an order in which each row has what it needs."""

from __future__ import annotations

import tempfile
from pathlib import Path

from dashboard.recordings_rig import record_fault

from .on_chart import CHART
from .on_connection import CONNECTION, OFF
from .on_live import ACTIONS, FRAME, LIVE
from .on_recordings import RECORDINGS
from .on_unit import ANOTHER_CAR, UNIT
from .routes import CAR, get, post, samples


def _fault() -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        return record_fault(Path(folder) / "fault.pcapng").read_bytes()


READY = (
    post("/control/take", {"force": True}),
    post("/connect", {"port": f"{CAR}&faults=17,81"}),
    get("/state", until=samples),
    post("/recording/start", {"name": "drive"}),
    get("/state", until=lambda it: (it["recording"] or {"samples": 0})["samples"] > 20),
    post("/recording/marker", {"label": "knock"}),
    get("/state", until=lambda it: it["recording"]["samples"] > 40),
    post("/recording/stop"),
    post("/recordings", lambda kept: _fault(), "/recordings?name=fault.pcapng"),
    post("/control/release"),
)
"""What the rows need: a virtual car with faults, that samples, a recording with a marker, and one
in which a fault comes."""
BEFORE = OFF
"""What is done before anything is connected."""
ROWS = (*FRAME, *UNIT, *CHART, *RECORDINGS, *LIVE, *ACTIONS, *CONNECTION, *ANOTHER_CAR)

NAMED = (
    "chart/time/ChartHeader {text}",
    "dialogs/Confirm {verb}",
    'dialogs/ConfirmChange {typeof verb === "string" ? verb : verb(proposal)}',
    "passport/Screen probing",
    "passport/Screen relearning",
    "recordings/RowActions Button",
    "recordings/RowActions {word}",
    "recordings/player/PlayerBar {name}",
    "tests/RecordedView stop",
)
"""Names that a control gets from those that the rows have: of a list, or while it is busy."""
ELSEWHERE = {
    "band/BandStrips connection": "browser/test_browser_connection.py",
    "band/BandStrips take": "browser/test_browser_sharing.py",
    "band/BandStrips {broken}": "browser/test_browser_widths.py",
    "car/CarSheet later": "browser/test_browser_guided_tests.py",
    "causes/CauseCard show": "../web/src/screens/causes/Causes.test.ts",
    "channelCard/ChannelCard watch": "../web/src/components/channelCard/ChannelCard.test.ts",
    "chart/time/moments/MomentsBar markAll": "../web/src/components/frame/MarkerName.test.ts",
    "connection/Network lan_copy": "browser/test_browser_lan.py",
    "connection/Ports choose": "static_site/test_site_car.py",
    "connection/Ports connect_to": "static_site/test_site_car.py",
    "connection/Ports others": "browser/test_browser_connection.py",
    "connection/Program program_end": "browser/test_browser_connection.py",
    "connection/Screen choose": "static_site/test_site_car.py",
    "connection/diagnosis/Doctor other_units": (
        "../web/src/screens/connection/diagnosis/Doctor.test.ts"
    ),
    "connection/diagnosis/ProblemReport report_form": (
        "../web/src/screens/connection/diagnosis/ProblemReport.test.ts"
    ),
    "connection/instruments/AddInstrument choose": "static_site/test_site_instruments.py",
    "connection/survey/Asked answer": "../web/src/screens/connection/survey/Survey.test.ts",
    "connection/survey/Asked cannot": "../web/src/screens/connection/survey/Survey.test.ts",
    "connection/survey/Asked done": "../web/src/screens/connection/survey/Survey.test.ts",
    "connection/survey/Asked no_figure": "../web/src/screens/connection/survey/Survey.test.ts",
    "connection/survey/Before choose": "../web/src/screens/connection/survey/Survey.test.ts",
    "connection/survey/Before start": "../web/src/screens/connection/survey/Survey.test.ts",
    "connection/survey/Saved issues": "../web/src/screens/connection/survey/Survey.test.ts",
    "faults/EraseSheet erase_yes": "../web/src/screens/faults/EraseSheet.test.ts",
    "faults/FaultCard watch": "../web/src/screens/faults/Faults.test.ts",
    "faults/FreezeFrame frame_delete": "browser/test_browser_faults.py",
    "faults/FreezeFrame frame_delete_yes": "browser/test_browser_faults.py",
    "live/Screen choose": "static_site/test_site_phone.py",
    "notices/IgnitionOnly hide": "../web/src/components/notices/IgnitionOnly.test.ts",
    "notices/IgnitionOnly show": "../web/src/components/notices/IgnitionOnly.test.ts",
    "recordings/trip/Screen save": "browser/test_browser_trips.py",
    "sources/SourcePicker together": "browser/test_browser_causes.py",
    "notices/ErrorNotice take": "browser/test_browser_sharing.py",
    "tests/co/Figure take": "../web/src/screens/tests/co/Co.test.ts",
    "tests/RecordedView show": "browser/test_browser_guided_tests.py",
}
"""What needs another car, computer or person, and the tests that bring it there: of a browser, or
the component's own."""
