"""Knowledge: the shipped causes, and those in a user's folder."""

from __future__ import annotations

from pathlib import Path

import pytest
from tools.causes.cars import name_of

from mikas.causes.features import Seen
from mikas.causes.knowledge import load
from mikas.causes.model import squeezed
from mikas.causes.ranking import Observation, rank_observation
from mikas.causes.result import CauseVerdict
from mikas.causes.weights import shipped
from mikas.virtual.defects.table import SIDES

OWN = """\
id = "squealing_belt"
complaints = ["battery"]
[text]
en = "The belt slips"
ru = "Проскальзывает ремень"
[check]
en = "Look at the belt."
ru = "Осмотрите ремень."
[effects]
voltage-idle = 8
idle-advance = -6
"""


def test_every_defect_of_the_virtual_car_is_a_known_cause_with_weights() -> None:
    names = {name_of(side) for side in SIDES}
    assert names == set(load().causes)
    assert names == set(shipped().table.means)


def test_the_causes_that_look_alike_exist() -> None:
    causes = load().causes.values()
    ids = {cause.id for cause in causes}
    assert all(set(cause.looks_like) <= ids for cause in causes)
    assert all(cause.systems and cause.complaints for cause in causes)


def test_a_cause_of_the_users_is_ranked(tmp_path: Path) -> None:
    (tmp_path / "squealing_belt.toml").write_text(OWN, "utf-8")
    known = load(tmp_path)
    assert not known.errors
    weights = shipped()
    off = dict.fromkeys(weights.scales, 0.0)
    off |= {"voltage-idle": squeezed(8.0), "idle-advance": squeezed(-6.0)}
    seen = {
        name: Seen(weights.scales[name].middle, weights.scales[name].middle, ()) for name in off
    }
    observation = Observation(off, seen, {}, {}, 700.0, ran=True)
    ranking = rank_observation(observation, known, weights)
    assert ranking.verdict is CauseVerdict.CAUSES
    assert ranking.causes[0].id == "squealing_belt"


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("[text]\nen = 'a'\n", "[text] and [check]"),
        ("[text]\nen = 'a'\n[check]\nen = 'b'\n", "[effects]"),
        (OWN.replace("voltage-idle", "voltage-ilde"), "no feature"),
        (OWN.replace('"battery"', '"batery"'), "must be one of"),
        ("= 3", "line 1"),
    ],
)
def test_a_wrong_file_is_an_error_with_its_place(tmp_path: Path, text: str, problem: str) -> None:
    (tmp_path / "wrong.toml").write_text(text, "utf-8")
    known = load(tmp_path)
    (error,) = known.errors
    assert problem in str(error)
    assert "wrong.toml" in str(error)
    assert len(known.causes) == len(load().causes)


def test_no_folder_is_no_error(tmp_path: Path) -> None:
    assert load(tmp_path / "none") == load()
