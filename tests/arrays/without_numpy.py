"""A pytest plugin: mikas, and the tests themselves, over the arrays of the browser.

    python -m pytest -p arrays.without_numpy tests/recording

What only tests take from numpy is made here of those arrays, or of lists.
"""

from __future__ import annotations

import math
import sys
from types import ModuleType, SimpleNamespace

from mikas.browser.arrays import install

install()

import numpy as np  # noqa: E402  (the arrays of the browser)


def same(one, other):
    """Whether two values are equal, NaN as well."""
    return one == other or (one != one and other != other)


def listed(values):
    if isinstance(values, float | int):
        return [values]
    return [float(each) for each in values]


def assert_array_equal(actual, expected, *_, strict=False):
    one, other = listed(actual), listed(expected)
    if len(one) == 1 or len(other) == 1:
        count = max(len(one), len(other))
        one, other = (each * count if len(each) == 1 else each for each in (one, other))
    assert len(one) == len(other)
    assert all(map(same, one, other)), (one, other)


def assert_allclose(actual, expected, rtol=1e-7, atol=0.0):
    one, other = listed(actual), listed(expected)
    assert len(one) == len(other)
    for a, b in zip(one, other, strict=True):
        assert same(a, b) or math.isclose(a, b, rel_tol=rtol, abs_tol=atol), (a, b)


def isscalar(value):
    return isinstance(value, float | int | str | bytes)


def _random() -> ModuleType:
    """What hypothesis looks for: it keeps the state of numpy's generator."""
    module = ModuleType("numpy.random")
    state = SimpleNamespace(value=None)
    module.seed = lambda value: setattr(state, "value", value)
    module.get_state = lambda: state.value
    module.set_state = lambda value: setattr(state, "value", value)
    return module


np.testing = SimpleNamespace(assert_array_equal=assert_array_equal, assert_allclose=assert_allclose)
np.isscalar = isscalar
np.broadcast_to = lambda value, shape: np.zeros(shape[0]) + value
np.__version__ = "0"
np.random = sys.modules["numpy.random"] = _random()
