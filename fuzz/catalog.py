"""A user's catalog file: a `CatalogError` at a line of the file, else a catalog that works.

Input: the file. It is laid over `BASE`, which is small for speed and has entries to override. Of a
catalog that loads, every conversion must lead back to its raw bytes, and every formula compute the
same number alone and in a column.
"""

from __future__ import annotations

from math import inf, nan
from typing import Final

import numpy as np

from mikas.catalog import Catalog, Parameter
from mikas.catalog.loading.loader import combined
from mikas.catalog.loading.source import CatalogFile, lines_of, parse_source
from mikas.errors import CatalogError

BASE: Final = parse_source(
    "base.toml",
    """
version = "1"
[unit.rpm]
text = { en = "rpm", ru = "об/мин" }
[parameter.FREQ]
code = 1
size = 2
unit = "rpm"
scale = 0.25
limits = { warning_high = 6000 }
text = { en = "Engine speed", ru = "Обороты" }
[parameter.LAMP]
code = 2
size = 1
mask = 4
text = { en = "Lamp", ru = "Лампа" }
[derived.HALF]
formula = "FREQ / 2"
text = { en = "Half the speed", ru = "Пол-оборота" }
[fault.13]
text = { en = "Sensor", ru = "Датчик" }
[model.0x09]
text = { en = "Mikas", ru = "Микас" }
""".encode(),
)
WORDS: Final = (
    *("[parameter.A]\n", "[derived.A]\n", "[fault.13]\n", "[model.1]\n", "[erratum.E]\n"),
    *("limits.", "literal.", "meaning.", "lamp.", "constants.", "text.", '{ en = "", ru = "" }'),
    *("scale = ", "offset = ", "bias = ", "mask = ", "signed = true\n", "range = [0, 1]\n"),
    *("formula = ", "where(", "min(", "abs(", " ** ", " and ", " not ", " < ", " % ", " if "),
    *("1e400", "-inf", "nan", "0x7fffffffffffffff", "1e-300", '"1/3"', "1979-05-27", '"""', "'''"),
)


def check(data: bytes) -> None:
    try:
        own = parse_source("own.toml", data)
    except CatalogError as error:
        _check_error(error, data)
        return
    _check_lines(own)
    try:
        catalog = combined([BASE, own])
    except CatalogError as error:
        _check_error(error, data)
        return
    for parameter in catalog.parameters:
        _check_parameter(parameter)
    _check_derived(catalog)


def _check_error(error: CatalogError, data: bytes) -> None:
    assert error.problem.en
    assert error.problem.ru
    assert error.file == "own.toml"
    assert 0 <= error.line <= data.count(b"\n") + 1


def _check_lines(own: CatalogFile) -> None:
    lines = lines_of(own.text)
    for name in own.tables:
        assert 1 <= lines[name,] <= own.text.count("\n") + 1


def _check_parameter(parameter: Parameter) -> None:
    assert parameter.text.en
    for name, conversion in parameter.interpretations.items():
        assert parameter.formula(name)
        low, high = conversion.raw_limits
        for number in (low, low + 1, (low + high) // 2, high):
            raw = number.to_bytes(conversion.size, "little", signed=conversion.signed)
            value = conversion.decode(raw)
            if not conversion.is_flag:
                assert conversion.encode(value, parameter.name) == raw


def _check_derived(catalog: Catalog) -> None:
    numbers = (0.0, 1.0, -2.5, 1e308, inf, nan)
    for derived in catalog.derived.values():
        calculation = derived.calculation()
        columns = {name: np.array(numbers) for name in derived.inputs}
        of_columns = np.broadcast_to(calculation.column(columns), len(numbers))
        for at, value in enumerate(numbers):
            of_number = calculation.number(dict.fromkeys(derived.inputs, value))
            assert np.array_equal(of_number, of_columns[at], equal_nan=True)
