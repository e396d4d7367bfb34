"""Take the pictures of the survey, "Help the project: ten minutes", on a desktop and on a phone.

A virtual car with its engine off for four minutes, then at idle, then at 2,500 rpm, at a port. It
takes nine minutes. From the repository's root: python docs/pictures/survey_screens.py [NAME …]
"""

from __future__ import annotations

import sys
import time
from typing import Any

import served_car
from served_car import DESKTOP, PHONE, ask

WHERE = "connection/survey"
RPM = 880  # of the virtual car at idle


def wait_for(regime: str) -> dict[str, Any]:
    """Wait until the survey waits for this state of the car, or has ended; return its state."""
    while True:
        state = ask("/survey", method="GET")
        if state["phase"] != "running":
            return state
        if (asked := state["asked"]) is not None:
            ask("/survey/answer", {"id": asked["id"], "done": True, "figure": RPM})
        if state["instruction"] and state["step"] and state["step"]["regime"] == regime:
            return state
        time.sleep(0.5)  # the real program, looked at twice a second


def photograph(name: str, wanted: list[str], there: str) -> None:
    """Take the picture in both languages; that of a step on a phone, too."""
    phone = [(PHONE, "phone-")] if name == "survey-start" else []
    for size, beginning in ((DESKTOP, ""), *phone):
        with served_car.tabs(wanted, size) as tabs:
            for tab in tabs:
                tab.show(WHERE)
                tab.page.locator(there).first.wait_for()
                tab.take(beginning + name)


def main(wanted: list[str]) -> None:
    """Go through the survey, and take its pictures."""
    with served_car.program_at_ports("survey"):
        photograph("survey-before", wanted, "#screen .facts")
        if wanted and all(name.endswith("survey-before") for name in wanted):
            return
        ask("/control/take", {"force": True})
        ask("/survey/start", {"voltmeter": 12.6})
        state = wait_for("starting")
        assert state["phase"] == "running", state["error"]
        photograph("survey-start", wanted, "#screen .todo")
        if wanted and not any(name.endswith("survey-answers") for name in wanted):
            return
        state = wait_for("")
        assert state["phase"] == "finished", state
        photograph("survey-answers", wanted, "#screen .answers li")


if __name__ == "__main__":
    main(sys.argv[1:])
