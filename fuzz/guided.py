"""A user's guided test: a `CatalogError` at a line of the file, else a test that runs.

Input: the file. A test that loads is run over values that rise and fall, with a gap in them; its
result must be readable as JSON again, and every text must have its numbers filled in.
"""

from __future__ import annotations

import json
from typing import Final

from mikas.catalog import shipped
from mikas.catalog.loading.source import parse_source
from mikas.errors import CatalogError
from mikas.guided.engine import TestEngine
from mikas.guided.loading import from_source
from mikas.guided.result import read

WORDS: Final = (
    *("[step.a]\n", "[measure.A]\n", "[rule.a]\n", "target.TWAT = [0, 1]\n", "until = ", "of = "),
    *("when = ", "by = ", "hold = ", "last = ", "fewest = ", "prepare = ", "longest_gap = "),
    *('statistic = "slope"\n', '"fall"', '"jump"', '"share"', '"percentile"', "percentile = 5\n"),
    *(
        "SECONDS",
        "FREQ",
        "UACC",
        "AIR_STROKE",
        "{A}",
        "{A!r}",
        "{",
        " and ",
        " / ",
        " ** ",
        "1e999",
    ),
)


def check(data: bytes) -> None:
    try:
        test = from_source(parse_source("own.toml", data), shipped())
    except CatalogError as error:
        _check_error(error, data)
        return
    engine = TestEngine(test, shipped())
    for number in range(60):
        time = number / 4 + 5 * (number > 40)
        level = float(number % 20)
        engine.add_row(time, dict.fromkeys(test.channels, level))
        progress = engine.progress()
        assert 0 <= progress.held <= progress.hold or progress.step is None
        if number == 55:
            engine.skip_all([step.name for step in test.steps])
    if engine.result is not None:
        again = read(json.loads(json.dumps(engine.result.as_json(), allow_nan=False)))
        assert again is not None
        assert again.outcome is engine.result.outcome
        assert all(engine.result.as_text())


def _check_error(error: CatalogError, data: bytes) -> None:
    assert 0 <= error.line <= data.count(b"\n") + 1
    assert error.problem.en
    assert error.problem.ru
