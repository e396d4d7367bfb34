"""The Russian page of the benchmarks is the English one, with every sentence translated."""

from __future__ import annotations

import re
import tomllib

import pytest
from bench.russian import RUSSIAN, Translation, translated
from bench.russian import TEXTS as FILE

TEXTS = {"{} of {} runs": "прогоны: {1} из {0}", "Load time": "Загрузка"}


def test_every_sentence_is_translated() -> None:
    text, missing = translated()
    assert not missing, "to bench/russian/texts.toml, then: python -m bench.russian"
    assert text == RUSSIAN.read_text("utf-8"), "python -m bench.russian"


@pytest.mark.parametrize(
    ("english", "russian"),
    [
        ("# Load time", "# Загрузка"),
        ("1,234 of 56,789.5 runs", "прогоны: 56 789,5 из 1234"),
        ("| Load time |  | 3.5 |\n|---|---|---|", "| Загрузка |  | 3,5 |\n|---|---|---|"),
        ("`stream` 3.4", "`stream` 3,4"),
        ("- Load time: 7 of 8 runs", "- Загрузка: прогоны: 8 из 7"),
        (
            "*2026-11-23; CPU 2.50GHz, 2 cores; Python 3.11.7; load average before it 0.3.*",
            "*2026-11-23; CPU 2.50GHz, ядер: 2; Python 3.11.7; средняя загрузка до этого 0,3.*",
        ),
    ],
)
def test_a_part_of_a_document_is_translated_whole(english: str, russian: str) -> None:
    translation = Translation(TEXTS)
    assert translation.document(english).split() == russian.split()
    assert not translation.missing


def test_what_has_no_translation_stays_and_is_named() -> None:
    translation = Translation(TEXTS)
    assert translation.document("Load time. Or 3.5 of it.") == "Load time. Or 3.5 of it.\n"
    assert translation.missing == {"Load time.", "Or {} of it."}


def test_a_translation_has_the_numbers_of_its_english() -> None:
    """`{0}` and `{1}` change their order; none may be lost."""
    for english, russian in tomllib.loads(FILE.read_text("utf-8")).items():
        numbers = [str(n) for n in range(english.count("{}"))]
        assert russian.format(*numbers)
        assert len(re.findall(r"\{\d?\}", russian)) == len(numbers), english
