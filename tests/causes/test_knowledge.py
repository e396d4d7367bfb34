"""Knowledge: the shipped causes, and those in a user's folder."""

from __future__ import annotations

import re
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


APART = """\
[apart.alternator]
do = { en = "Throw water on the belt.", ru = "Плесните водой на ремень." }
this = "it is silent"
other = { en = "nothing changes" }
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


def test_what_separates_by_hand_is_of_another_cause_and_in_both_languages() -> None:
    known = load().causes
    tests = [(each, other) for each in known.values() for other in each.apart]
    assert len(tests) > 9
    ids = {cause.id for cause in known.values()}
    for cause, other in tests:
        assert other in known or other in ids
        assert other.partition("-")[0] != cause.id
        test = cause.apart[other]
        for text in (test.do, test.this, test.other):
            assert text.en
            assert re.search("[А-яЁё]", text.ru)
            assert not re.search("[А-яЁё]", text.en)


def test_a_user_s_cause_is_separated_by_hand_from_a_shipped_one(tmp_path: Path) -> None:
    (tmp_path / "squealing_belt.toml").write_text(OWN + APART, "utf-8")
    known = load(tmp_path)
    assert not known.errors
    test = known.causes["squealing_belt"].apart_from(known.causes["alternator"])
    assert test is not None
    assert (test.do.ru, test.this.ru, test.other.ru) == (
        "Плесните водой на ремень.", "it is silent", "nothing changes",
    )  # fmt: skip
    assert known.causes["alternator"].apart_from(known.causes["squealing_belt"]) is None


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
        (
            OWN + APART.replace("alternator", "alternatr"),
            "wrong.toml:12: `apart.alternatr` is not the",
        ),
        (OWN + APART.replace("alternator", "squealing_belt"), "is not the id of another cause"),
        (OWN + APART.replace("alternator", "alternator-low"), "is not the id of another cause"),
        (OWN + APART.replace("other =", "others ="), "unknown key `others`"),
        (OWN + APART.partition("other =")[0], "needs `other`"),
        (OWN + "[apart]\nalternator = 3\n", "must be a table"),
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
