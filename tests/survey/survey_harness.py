"""A survey of a virtual unit on simulated time: the car is started and raised by its timeline."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mikas.client.connecting import ConnectionOptions, open_ecu
from mikas.i18n import Text
from mikas.survey import Survey, SurveyAnswer, SurveyFile, SurveyOptions, Unattended
from mikas.survey.steps.step import SurveyStep

DRIVE = """
duration = 3600
after_end = "hold"
[start]
ambient = 20
coolant = 82
coolant_at_start = 20
[timeline]
key = 1
starter = [[0, 0], [{start}, 1], [{started}, 0]]
throttle = [[0, 0], [{raise}, 0], [{raised}, 6], [{lower}, 6], [{lowered}, 0]]
gear = 0
"""


def drive(
    folder: Path, *, starts: float = 240.0, raises: float = 420.0, raised: float = 60.0
) -> Path:
    """Returns the file of a scenario: the engine is started, and raised for `raised` seconds."""
    times = {
        "start": starts, "started": starts + 3, "raise": raises, "raised": raises + 2,
        "lower": raises + raised, "lowered": raises + raised + 2,
    }  # fmt: skip
    file = folder / "drive.toml"
    file.write_text(DRIVE.format_map(times), "utf-8")
    return file


@dataclass
class Beside:
    """A person with instruments; `stop` is called at each sign of progress and may raise."""

    figures: Mapping[str, float] = field(default_factory=dict)
    stop: Callable[[], None] = lambda: None
    said: list[Text] = field(default_factory=list)

    def say(self, text: Text, /) -> None:
        self.said.append(text)

    def progress(self, *_: int) -> None:
        self.stop()

    def ready(self, text: Text, /) -> bool:
        self.said.append(text)
        return True

    def number(self, name: str, *_: object) -> float | None:
        return self.figures.get(name)


def url_of(file: Path | None, **settings: object) -> str:
    """Returns the port of a virtual unit that drives by `file`."""
    given = {"clock": "simulated", **settings}
    if file is not None:
        given["scenario"] = str(file)
    return "sim:?" + "&".join(f"{name}={value}" for name, value in given.items())


def surveyed(
    url: str,
    out: Path,
    person: Any = None,
    on_step: Callable[[SurveyStep, int, int], None] = lambda *_: None,
    **options: bool,
) -> SurveyFile:
    """Surveys the unit and writes the ZIP."""
    with open_ecu(url, ConnectionOptions()) as ecu:
        survey = Survey(ecu, out, SurveyOptions(**options), person or Unattended())
        survey.run(on_step)
        return survey.save()


def by_name(found: SurveyFile) -> dict[str, SurveyAnswer]:
    return {answer.id: answer for answer in found.answers}
