"""Counts in two languages, and that no text has an ending in brackets."""

from __future__ import annotations

import pytest

from mikas.client.erasing import erasing
from mikas.client.memory.spaces import writing
from mikas.i18n import Text, byte_count, unit_after


@pytest.mark.parametrize(
    ("count", "en", "ru"),
    [
        (0, "0 bytes", "0 байт"),
        (1, "1 byte", "1 байт"),
        (2, "2 bytes", "2 байта"),
        (5, "5 bytes", "5 байт"),
        (11, "11 bytes", "11 байт"),
        (21, "21 bytes", "21 байт"),
        (112, "112 bytes", "112 байт"),
        (256, "256 bytes", "256 байт"),
    ],
)
def test_a_count_of_bytes_has_the_unit_of_each_language(count, en, ru) -> None:
    assert byte_count(count) == (en, ru)


def test_changes_have_the_right_ending() -> None:
    assert [erasing(count).en for count in (1, 2)] == [
        "erase 1 stored fault",
        "erase 2 stored faults",
    ]
    assert [erasing(count).ru for count in (1, 2, 5)] == [
        "сбросить 1 ошибку",
        "сбросить 2 ошибки",
        "сбросить 5 ошибок",
    ]
    assert writing(1, "ram 0042") == ("write 1 byte to ram 0042", "записать 1 байт, ram 0042")


@pytest.mark.parametrize(
    ("shown", "en", "ru"),
    [
        ("0", "steps", "шагов"),
        ("1", "step", "шаг"),
        ("−1", "step", "шаг"),
        ("31", "steps", "шаг"),
        ("32", "steps", "шага"),
        ("11", "steps", "шагов"),
        ("36", "steps", "шагов"),
        ("2.5", "steps", "шага"),
        ("–", "steps", "шага"),
    ],
)
def test_a_counted_unit_has_the_form_of_its_number(shown, en, ru) -> None:
    number = Text(shown, shown.replace(".", ","))
    assert unit_after(number, Text("steps", "шаг")) == (en, ru)
    assert unit_after(number, Text("rpm", "об/мин")) == ("rpm", "об/мин")
