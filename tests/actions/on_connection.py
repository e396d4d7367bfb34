"""What a person does on Connection: adapters, virtual cars, the check."""

from __future__ import annotations

from .on_live import BAND
from .steps import CLOSED, SHEET, Shot, fill, go, on_screen, press, row, saves, says, shows

SAMPLES = shows(f"{BAND}[data-line=sampling]")
SCREEN = "#screen"

OFF = (
    row(
        "live",
        "it leads to Connection",
        press("live/Screen connect"),
        on_screen("connection"),
        homes=("desktop",),
    ),
    # Beside the browser's own list, which a test can't open.
    row(
        "live",
        "it leads to Connection",
        press("live/Screen connectOther"),
        on_screen("connection"),
        homes=("site",),
    ),
)
CONNECTION = (
    row(
        "connection",
        "the check, from its start",
        press("connection/FirstTime first"),
        press("connection/Ports refresh"),
        press("connection/diagnosis/Doctor doctor_start"),
        shows(f"{SCREEN} button:has-text('Run check again'):enabled"),
        press("connection/diagnosis/Doctor doctor_again"),
        press("connection/diagnosis/Doctor doctor_stop"),
        press("connection/diagnosis/ProblemReport report"),
        press("connection/diagnosis/ProblemReport report_copy"),
        SAMPLES,
    ),
    row(
        "connection",
        "disconnected, and another port",
        press("band/RecordControl record", within=BAND),
        shows(f"{BAND}[data-line=recording]"),
        press("connection/VirtualCar sim_go"),
        press("dialogs/Confirm cancel"),
        CLOSED,
        press("connection/VirtualCar sim_go"),
        press("connection/Screen connect", within=SHEET),
        on_screen("live"),
        shows(f"{BAND}[data-line=recording]"),
        go("connection"),
        press("connection/Ports disconnect", within=SCREEN),
        press("connection/Screen disconnect", within=SHEET),
        shows(f"{BAND}[data-line=off]"),
        go("passport"),
        press("notices/NoEcu go"),
        on_screen("connection"),
        press("connection/Ports other_port"),
        fill("Another port", "sim:?scenario=warm-idle"),
        press("connection/Ports connect", css=f"{SCREEN} details form [type=submit]"),
        SAMPLES,
    ),
    row(
        "connection",
        "the survey for the project, stopped, shown and saved",
        press("connection/survey/SurveyCard open"),
        says("What is allowed"),
        press("connection/survey/Screen back"),
        press("connection/survey/SurveyCard open"),
        press("connection/survey/Before virtual"),
        shows(f"{SCREEN} .todo", "Ignition on, engine off"),
        Shot("leading"),
        go("connection"),
        press("connection/survey/SurveyCard open_running"),
        press("connection/survey/Leading stop"),
        says("What was measured is kept"),
        press("connection/survey/Content forget"),
        press("dialogs/Confirm cancel"),
        CLOSED,
        press("connection/survey/Content go_on"),
        shows(f"{SCREEN} .todo", "Ignition on, engine off"),
        press("connection/survey/Leading stop"),
        press(
            "connection/survey/Content {member.name}", css=f"{SCREEN} details:first-of-type summary"
        ),
        Shot("content"),
        press("connection/survey/Content save"),
        shows(f"{SCREEN} h2", "Saved: virtual-survey"),
        saves("connection/survey/Saved download"),
        go("connection"),
        SAMPLES,
    ),
    row(
        "connection",
        "virtual cars to choose",
        press("connection/VirtualCar {t(word)}", css=f"{SCREEN} section .quiet"),
        on_screen("live"),
        go("connection"),
        SAMPLES,
        press("connection/virtual/CarForm choose"),
        press("connection/virtual/CarForm {t(each)}", name="^Carburettor"),
        shows(SCREEN, "controls the ignition alone"),
        Shot("carburettor"),
        press("connection/virtual/CarForm {t(each)}", name="^Find out"),
        press("connection/virtual/CarForm another"),
        press("connection/virtual/CarForm start"),
        on_screen("live"),
        SAMPLES,
        go("connection"),
        press("connection/virtual/BlindAnswer show"),
        shows(f"{SCREEN} .blind [role=status]"),
        press("connection/VirtualCar sim_go"),
        on_screen("live"),
        SAMPLES,
    ),
)
