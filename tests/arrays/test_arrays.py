"""The arrays of the browser against numpy: every function and method, on any values."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mikas.browser.arrays import names as browser

FLOATS = st.one_of(
    st.sampled_from([0.0, -0.0, 1.0, -1.0, 0.5, 2.5, math.nan, math.inf, -math.inf, 1e300]),
    st.floats(allow_nan=True, allow_infinity=True),
    st.integers(-5, 5).map(float),
)
PLAIN = st.floats(-1e6, 1e6)
SMALL = st.integers(-9, 9)
TYPES = {"float64": FLOATS, "int64": SMALL, "bool_": st.booleans()}
ONE_BY_ONE = ["isnan", "isfinite"], ["floor", "ceil", "rint", "abs", "negative"], ["sqrt"]
COMPARED = ["less", "less_equal", "greater", "greater_equal", "equal", "not_equal"]
COMPUTED = ["add", "subtract", "multiply", "divide", "minimum", "maximum", "fmin", "fmax"]


def both(values, of="float64"):
    """The same values as arrays of numpy and of the browser."""
    return tuple(it.array(values, getattr(it, of)) for it in (np, browser))


def plain(it):
    if isinstance(it, tuple):
        return tuple(map(plain, it))
    if isinstance(it, np.ndarray | browser.ndarray):
        return ([plain(each) for each in it.tolist()], str(it.dtype).replace("dtype('", "")[:4])
    if isinstance(it, np.generic):
        return plain(it.item())
    return "nan" if isinstance(it, float) and math.isnan(it) else it


def outcome(work):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return plain(work())
        except (ValueError, IndexError) as error:
            return type(error)


def same(work, *arrays):
    """`work(module, *arrays)` gives the same with numpy's arrays and the browser's."""
    expected = outcome(lambda: work(np, *(one for one, _ in arrays)))
    assert outcome(lambda: work(browser, *(other for _, other in arrays))) == expected


def arrays(values=FLOATS, of="float64", **size):
    return st.lists(values, max_size=9, **size).map(lambda drawn: both(drawn, of))


def pairs(values=FLOATS, other=None, of="float64", and_of=None):
    rows = st.lists(st.tuples(values, values if other is None else other), max_size=9)
    return rows.map(
        lambda drawn: (both([a for a, _ in drawn], of), both([b for _, b in drawn], and_of or of))
    )


masked = pairs(FLOATS, st.booleans(), and_of="bool_")
indexed = st.lists(FLOATS, min_size=1, max_size=9).flatmap(
    lambda drawn: st.tuples(
        st.just(both(drawn)),
        st.lists(st.integers(-len(drawn), len(drawn) - 1), max_size=6).map(
            lambda places: both(places, "int64")
        ),
    )
)


@given(arrays(), arrays(SMALL, "int64"), FLOATS)
def test_functions_of_one_array_agree_with_numpy(floats, numbers, number):
    for name in [each for names in ONE_BY_ONE for each in names]:
        same(lambda np, a, f=name: getattr(np, f)(a), floats)
        same(lambda np, f=name: getattr(np, f)(number))
    for name in ("abs", "negative"):
        same(lambda np, a, f=name: getattr(np, f)(a), numbers)
    same(lambda np, a: -a, floats)


@given(pairs(), pairs(SMALL, of="int64"), pairs(SMALL, FLOATS, "int64", "float64"), FLOATS, SMALL)
def test_functions_of_two_arrays_agree_with_numpy(floats, numbers, mixed, number, whole):
    for name in COMPUTED + COMPARED:
        for two in (floats, numbers, mixed):
            same(lambda np, a, b, f=name: getattr(np, f)(a, b), *two)
        for array in (floats[0], numbers[0]):
            for single in (number, whole):
                same(lambda np, a, f=name, y=single: getattr(np, f)(a, y), array)
                same(lambda np, a, f=name, y=single: getattr(np, f)(y, a), array)
        same(lambda np, f=name: getattr(np, f)(number, float(whole)))


@given(pairs(), FLOATS)
def test_operators_agree_with_numpy(two, number):
    same(lambda _, a, b: (a + b, a - b, a * b, a / b), *two)
    same(lambda _, a: (a + number, number - a, a * number, number / a, a / number), two[0])
    same(lambda _, a, b: (a < b, a <= b, a > b, a >= b, a == b, a != b), *two)
    same(lambda _, a: (a < number, number < a, a == number, a != number), two[0])


def test_arrays_of_other_lengths_are_refused():
    with pytest.raises(ValueError, match="2 and 3"):
        browser.array([1.0, 2.0]) + browser.array([1.0, 2.0, 3.0])
    same(lambda np, a, b: a + b, both([1.0]), both([1.0, 2.0]))
    same(lambda np, a, b: a + b, both([1.0]), both([]))


@given(pairs(st.booleans(), of="bool_"), st.booleans())
def test_masks_combine_and_count_as_in_numpy(two, single):
    same(lambda _, a, b: (a & b, a | b, a ^ b, ~a), *two)
    same(lambda _, a: (a & single, a | single), two[0])
    same(lambda np, a, b: np.logical_and.reduce([a, b, a]), *two)
    same(lambda np, a: (a.sum(), a.cumsum(), a.any(), a.all(), a.nonzero()[0]), two[0])
    same(lambda np, a: (np.count_nonzero(a), np.flatnonzero(a), a.astype(np.int64)), two[0])
    same(lambda np, a: (a.argmin(), a.argmax()), two[0])
    same(lambda np, a: np.diff(a), two[0])


@given(masked, FLOATS, FLOATS, SMALL)
def test_where_chooses_as_in_numpy(two, x, y, whole):
    same(lambda np, a, m: (np.where(m, a, x), np.where(m, x, a), np.where(m, a, a)), *two)
    same(lambda np, a, m: (np.where(m, x, y), np.where(m, m, whole), np.where(m, a, m)), *two)
    same(lambda np, a: np.where(np.isnan(a), np.nan, np.equal(a, 0)), two[0])
    same(lambda np, a: np.clip(a, min(x, y), max(x, y)), two[0])


@given(indexed, st.slices(9), FLOATS)
def test_parts_by_index_slice_and_mask_agree_with_numpy(two, part, number):
    same(lambda _, a: a[part], two[0])
    same(lambda _, a, i: (a[i], a.take(i)), *two)
    same(lambda _, a: (a[a > number], a[0], a[-1]), two[0])
    same(lambda np, a: a[np.arange(len(a))], two[0])
    same(lambda np, a: np.arange(len(a))[1:][a[1:] > 0] + 3, two[0])


@given(indexed, st.lists(FLOATS, min_size=6, max_size=6), FLOATS, st.slices(9))
def test_assigned_parts_change_as_in_numpy(two, values, number, part):
    def changed(np, array, places):
        one, other, third, fourth = array.copy(), array.copy(), array.copy(), array.copy()
        one[places] = number
        other[places] = np.array(values[: places.size])
        third[third > number] = 1
        fourth[part] = number
        fourth[0] = 7
        return array, one, other, third, fourth

    same(changed, *two)

    def masked(np, array, _):
        copy = array.copy()
        chosen = copy < number
        copy[chosen] = array[chosen] + 1
        return copy, array

    same(masked, *two)


def test_a_slice_cannot_be_changed_nor_its_source():
    source = browser.array([1.0, 2.0, 3.0])
    part = source[1:]
    for array in (source, part):
        with pytest.raises(NotImplementedError):
            array[0] = 5.0
        with pytest.raises(NotImplementedError):
            array.__iadd__(1.0)
    copied = source.copy()
    copied[0] = 5.0
    assert (copied.tolist(), source.tolist()) == ([5.0, 2.0, 3.0], [1.0, 2.0, 3.0])


@given(arrays(), arrays(SMALL, "int64"), arrays(PLAIN))
def test_sums_and_extremes_agree_with_numpy(floats, numbers, finite):
    for array in (floats, numbers):
        same(lambda np, a: (a.min(), a.max(), np.max(a)), array)
        same(lambda np, a: (a.argmin(), a.argmax(), a.any(), a.all()), array)
    for name in ("nanmin", "nanmax", "nanargmin", "nanargmax"):
        same(lambda np, a, f=name: getattr(np, f)(a), floats)
    same(lambda np, a: (a.sum(), a.cumsum(), np.cumsum(a), a.size, a.shape, len(a)), numbers)
    same(lambda np, a: np.median(a), floats)
    for name in ("sum", "mean"):
        one, other = (outcome(getattr(each, name)) for each in finite)
        assert one == other or math.isclose(one, other, rel_tol=1e-9, abs_tol=1e-6)
    same(lambda np, a: np.cumsum(a), finite)


@given(arrays(PLAIN, min_size=1), st.integers(0, 100))
def test_percentiles_agree_with_numpy(array, share):
    one, other = array
    assert math.isclose(np.percentile(one, share), browser.percentile(other, share), abs_tol=1e-9)
    same(lambda np, a: np.median(a), array)


@given(arrays(), arrays(SMALL, "int64"), arrays(PLAIN))
def test_running_extremes_sums_and_differences_agree_with_numpy(floats, numbers, finite):
    for name in ("minimum", "maximum"):
        for array in (floats, numbers):
            same(lambda np, a, f=name: getattr(np, f).accumulate(a), array)
    for array in (floats, numbers):
        same(lambda np, a: np.add.accumulate(a), array)
        same(lambda np, a: (np.diff(a), np.diff(a, prepend=3)), array)
    same(lambda np, a: np.diff(a, prepend=-np.inf), finite)


@given(st.lists(FLOATS, min_size=1, max_size=12), st.data())
def test_extremes_of_parts_agree_with_numpy(values, data):
    places = data.draw(st.lists(st.integers(0, len(values) - 1), max_size=5).map(sorted))
    two = both(values), both(places, "int64")
    for name in ("fmin", "fmax", "minimum", "maximum"):
        same(lambda np, a, i, f=name: getattr(np, f).reduceat(a, i), *two)

    def put(np, array, at):
        kept = np.full(len(values), np.nan)
        at = at[: array.size]
        np.fmin.at(kept, at, array[: at.size])
        np.fmax.at(kept, at, array[: at.size] + 1)
        np.fmin.at(kept, at[::-1], array[: at.size])
        return kept

    same(put, *two)


@given(arrays(SMALL.map(float) | st.just(math.nan)), arrays(SMALL, "int64"), arrays(SMALL, "int64"))
def test_sorting_and_sets_agree_with_numpy(floats, numbers, others):
    for array in (floats, numbers):
        same(lambda np, a: (np.sort(a), a.argsort(kind="stable"), np.unique(a)), array)
        same(lambda np, a: np.unique(a, return_inverse=True), array)
        same(lambda np, a: np.unique(a, return_counts=True), array)
    same(lambda np, a, b: (np.isin(a, b), np.setdiff1d(a, b)), numbers, others)
    same(lambda np, a: np.isin(a, []), numbers)
    same(lambda np, a: np.bincount(abs(a)), numbers)
    same(lambda np, a: np.bincount(np.abs(a), np.abs(a)), numbers)


@given(arrays(SMALL.map(float)), arrays(SMALL.map(float)), st.sampled_from(["left", "right"]))
def test_a_binary_search_finds_the_places_that_numpy_finds(values, wanted, side):
    def search(np, a, b):
        rising = np.sort(a)
        found = np.searchsorted(rising, b, side), rising.searchsorted(b, side)
        return *found, rising.searchsorted([1.0, 2.0]), rising.searchsorted(1.0)

    same(search, values, wanted)


@given(arrays(), st.lists(st.integers(0, 9), max_size=4), FLOATS)
def test_insertion_agrees_with_numpy(array, places, number):
    def insert(np, a):
        at = np.array(sorted(min(place, len(a)) for place in places), np.int64)
        many = np.insert(a, at, np.arange(at.size) * 1.5)
        return many, np.insert(a, at, np.nan), np.insert(a, 0, number), np.append(a, number)

    same(insert, array)


@given(arrays(), arrays(SMALL, "int64"), st.lists(st.integers(0, 3), max_size=9))
def test_joining_and_repeating_agree_with_numpy(floats, numbers, counts):
    same(lambda np, a, b: np.concatenate((a, [1.5], b)), floats, numbers)
    same(lambda np, a: np.concatenate(([0], a, [a.size])), numbers)
    same(lambda np, a: np.concatenate(([True], a > 0)), numbers)
    same(lambda np, a: np.concatenate([np.empty(0), a, np.full(2, np.inf)]), floats)
    size = min(len(counts), floats[0].size)
    times = both(counts[:size], "int64")
    same(lambda np, a, b: np.repeat(a[: b.size], b), floats, times)
    same(lambda np, a: [each.tolist() for each in np.split(a, [1, 2])][1:2], numbers)
    same(lambda np, a: np.array_equal(a, a), floats)
    same(lambda np, a, b: np.array_equal(a, b, equal_nan=True), floats, floats)


@given(st.integers(0, 5), st.floats(-9, 9), st.floats(-9, 9), st.integers(2, 9))
def test_new_arrays_have_the_values_of_numpys(count, one, other, points):
    same(lambda np: (np.zeros(count), np.ones(count, np.bool_), np.full(count, -1)))
    same(lambda np: (np.full(count, np.nan), np.zeros(count, np.int64), np.full(count, True)))
    same(lambda np: (np.arange(count), np.arange(2, count), np.array([]), np.array([1, 2.5])))
    same(lambda np: (np.arange(count + 0.5), np.linspace(one, other, points)))
    same(lambda np: np.nextafter(one, np.inf))


@given(arrays(st.floats(-2e9, 2e9)), arrays(st.integers(-(2**40), 2**40), "int64"), arrays(PLAIN))
def test_conversion_of_types_agrees_with_numpy(floats, numbers, plain_ones):
    for of in ("int64", "int32", "float32", "bool_"):
        same(lambda np, a, of=of: a.astype(getattr(np, of)), floats)
    for of in ("int32", "int16", "uint8", "float64", "bool_"):
        same(lambda np, a, of=of: a.astype(getattr(np, of)), numbers)
    for of in (">f4", ">i4"):
        same(lambda np, a, of=of: a.astype(of).tobytes(), floats)
    same(lambda np, a: (a % 256).astype(np.uint8).tobytes(), numbers)
    same(lambda np, a: (a % 65_536).astype(">u2").tobytes(), numbers)
    same(lambda np, a: (a & 255, (a == 3).astype(np.float64)), numbers)
    for places in (0, 2, 4):
        same(lambda np, a, d=places: np.round(a, d), plain_ones)


@given(st.binary(max_size=9), st.integers(0, 255))
def test_arrays_of_bytes_are_read_as_by_numpy(data, byte):
    def work(np, raw):
        table = np.arange(256) * 0.5
        return raw == byte, raw.astype(np.int64), table[raw], raw[::2], raw.tobytes()

    same(work, (np.frombuffer(data, np.uint8), browser.frombuffer(data, browser.uint8)))


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_numbers_are_written_without_an_exponent_as_by_numpy(value):
    written = np.format_float_positional(value, trim="-")
    assert browser.format_float_positional(value, trim="-") == written


@settings(max_examples=30)
@given(arrays(PLAIN), arrays(PLAIN))
def test_a_function_of_numbers_is_applied_to_each_element(one, other):
    def work(np, a):
        return np.asarray(np.frompyfunc(lambda x, y: x * 2 + y, 2, 1)(a, 1.0), dtype=np.float64)

    same(work, one)


def test_what_numpy_has_and_we_lack_raises():
    floats = browser.array([1.0, 2.0])
    for work in (
        lambda: browser.polyfit,
        lambda: floats[:, 0],
        lambda: browser.array([[1.0], [2.0]]),
        lambda: floats // 2,
        lambda: floats**2,
        lambda: ~browser.array([1, 2]),
        lambda: browser.array([2**62, 2**62]) * 4,
        lambda: browser.array([math.nan]).astype(browser.int64),
        lambda: browser.frombuffer(b"\1\2", browser.uint8) + 1,
        lambda: browser.array(["a"]),
        lambda: np.asarray(floats),
    ):
        with pytest.raises(NotImplementedError):
            work()
    with pytest.raises(ValueError, match="ambiguous"):
        bool(floats)
    assert not hasattr(browser, "polyfit")


def test_an_array_is_no_value_of_another():
    floats, whole = browser.array([1.0, 2.0]), browser.array([1.0, 2.0])
    with pytest.raises(TypeError):
        floats[0] = whole
    with pytest.raises(TypeError):
        browser.full(2, whole, float)
    assert floats.tolist() == [1.0, 2.0]


def test_arrays_of_other_types_are_compared_as_by_numpy():
    numbers = both([1, 2], "int64")
    for values in ([1, 2], [1, 3]):
        same(lambda np, a, b: np.array_equal(a, b, equal_nan=True), numbers, both(values, "uint8"))
