"""Virtual cars to choose: the table, a car with a defect, and the answer to a blind one."""

from __future__ import annotations

import pytest

from mikas.virtual.defects.choosing import answer
from mikas.virtual.defects.table import SIDES


def test_the_scenarios_and_defects_are_listed_with_amounts(off):
    found = off.get("/virtual-cars")
    assert found["scenarios"][0]["name"] == "warm-idle"
    assert len(found["defects"]) == len(SIDES)
    leak = next(it for it in found["defects"] if it["key"] == "leak")
    assert (leak["sound"], leak["least"], leak["noticeable"], leak["most"]) == (0, 2, 6, 20)
    assert leak["text"]["ru"] == "Подсос воздуха мимо ДМРВ"
    assert leak["unit"]["ru"] == "кг/ч"
    assert all("{}" in it["phrase"]["en"] and "{}" in it["phrase"]["ru"] for it in found["defects"])


@pytest.mark.parametrize("car", ["blind:4711", "leak:8", "healthy"])
def test_the_answer_is_given_when_it_is_asked_for(off, car):
    found = off.get("/virtual-cars/answer", car=car)
    assert found["car"] == car
    expected = answer(car)
    assert [it["key"] for it in found["defects"]] == [it.key for it in expected]
    assert [it["text"]["ru"] for it in found["defects"]] == [it.text.ru for it in expected]


def test_a_car_that_there_is_not_has_no_answer(off):
    error = off.get("/virtual-cars/answer", 400, car="leek")
    assert error["code"] == "UsageError"
    assert "leak" in error["ru"]


def test_a_blind_car_gives_nothing_away_until_it_is_asked(off, monkeypatch):
    from mikas.link import open_link

    object.__setattr__(off.dashboard.settings, "open_port", open_link)
    key = answer("blind:4711")[0].key
    state = off.post("/connect", {"port": "sim:?car=blind:4711"})
    assert state["port"] == "sim:?car=blind:4711"
    assert key not in str(off.sampling())
    off.post("/disconnect")
