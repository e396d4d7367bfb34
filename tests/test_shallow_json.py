"""What nests too deep for a browser is seen before it is read."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.browser import shallow_json
from mikas.browser.shallow_json import DEEPEST, nests_too_deep

VALUES = st.recursive(
    st.none() | st.integers() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
)


def depth_of(value):
    if isinstance(value, dict):
        value = list(value.values())
    return 1 + max(map(depth_of, value), default=0) if isinstance(value, list) else 0


@given(value=VALUES, ascii_only=st.booleans())
def test_the_depth_is_that_of_the_value(value, ascii_only):
    text = json.dumps(value, ensure_ascii=ascii_only)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shallow_json, "DEEPEST", depth_of(value))
        assert not nests_too_deep(text)
        patch.setattr(shallow_json, "DEEPEST", depth_of(value) - 1)
        assert nests_too_deep(text) == (depth_of(value) > 0)


@pytest.mark.parametrize("opening", ["[", '{"a":', '{"[": ', "[1, ", '["\\"]", '])
def test_a_nesting_that_never_ends_is_too_deep(opening):
    assert nests_too_deep(opening * (DEEPEST + 1))
    assert not nests_too_deep(opening * DEEPEST)


def test_many_values_beside_each_other_are_no_depth():
    assert not nests_too_deep(json.dumps([{"]": ["[" * 10]}] * 10 * DEEPEST))
