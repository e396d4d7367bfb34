"""`mikas sim --answer`: what is wrong with a virtual car, without starting it."""

from __future__ import annotations

from mikas.virtual.defects.choosing import answer


def test_the_answer_names_the_defect(mikas):
    (expected,) = answer("blind:4711")
    ran = mikas("sim", "--answer", "blind:4711", "--lang", "en")
    assert (ran.status, ran.out) == (
        0,
        f"{expected.text.en} ({expected.key}:{expected.amount:g})\n",
    )
    shown = mikas("sim", "--answer", "blind:4711", "--json").object
    assert shown["defects"] == [
        {"key": expected.key, "amount": expected.amount, "text": expected.text._asdict()}
    ]


def test_a_sound_car_has_nothing(mikas):
    sound = next(f"blind:{number}" for number in range(99) if not answer(f"blind:{number}"))
    for car in (sound, "healthy"):
        assert "машина исправна" in mikas("sim", "--answer", car, "--lang", "ru").out
        assert mikas("sim", "--answer", car, "--json").object["defects"] == []
