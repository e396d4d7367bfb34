"""The types of values, and what results of several types are."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final


class dtype:  # noqa: N801  (numpy's name)
    """One type of values. Called, it converts one value: `np.float64(3)`.

    `kind`: `b`, `u`, `i`, `f` or `O`; `code`: that of the module `array`.
    """

    def __init__(
        self, name: str, kind: str, itemsize: int, code: str, *, swapped: bool = False
    ) -> None:
        self.name, self.kind, self.itemsize = name, kind, itemsize
        self.code, self.swapped = code, swapped

    def __call__(self, value: Any = 0) -> Any:  # noqa: ANN401  (a number of this type)
        """Return the value in this type."""
        return one(value, self)

    def __instancecheck__(self, value: object) -> bool:
        """Return False: single values are Python's own."""
        return False

    def __repr__(self) -> str:
        return f"dtype('{self.name}')"


bool_: Final = dtype("bool", "b", 1, "B")
uint8: Final = dtype("uint8", "u", 1, "B")
int16: Final = dtype("int16", "i", 2, "h")
int32: Final = dtype("int32", "i", 4, "i")
int64: Final = dtype("int64", "i", 8, "q")
float32: Final = dtype("float32", "f", 4, "f")
float64: Final = dtype("float64", "f", 8, "d")
object_: Final = dtype("object", "O", 4, "")
_BIG: Final = {
    ">u2": dtype(">u2", "u", 2, "H", swapped=True),
    ">i4": dtype(">i4", "i", 4, "i", swapped=True),
    ">f4": dtype(">f4", "f", 4, "f", swapped=True),
}
"""Only for files: values are converted to them and taken as bytes."""
_NAMED: Final = {
    "u1": uint8, "i2": int16, "i4": int32, "i8": int64, "f4": float32, "f8": float64, **_BIG,
}  # fmt: skip
_PYTHON: Final = {bool: bool_, int: int64, float: float64, object: object_}
STORED: Final = frozenset({float32, int16, int32, uint8, *_BIG.values()})
"""Values are kept and compared in these types; for arithmetic they are to be converted first."""


def dtype_of(given: object) -> dtype:
    """Return the type that numpy understands by `given`."""
    if isinstance(given, dtype):
        return given
    if isinstance(given, str) and given in _NAMED:
        return _NAMED[given]
    if isinstance(given, type) and given in _PYTHON:
        return _PYTHON[given]
    raise NotImplementedError(f"a type of values: {given!r}")


def scalar_type(value: object) -> dtype:
    """Return the type of one value."""
    if type(value) in _PYTHON and not isinstance(value, type):
        return _PYTHON[type(value)]
    raise NotImplementedError(f"a value of {type(value)}")


def promoted(one: dtype, other: dtype) -> dtype:
    """Return the type that has the values of both."""
    if one is other:
        return one
    both = {one, other}
    if both & STORED and both != {uint8, int64}:
        raise NotImplementedError(f"{one} with {other}")
    for kind in (object_, float64, int64):
        if kind in both:
            return kind
    raise NotImplementedError(f"{one} with {other}")


def with_scalar(array: dtype, value: object) -> dtype:
    """Return the type of an array's values together with a single number, as of NumPy 2."""
    single = scalar_type(value)
    if array.kind in "iu" and single is int64:
        return array
    return promoted(array, single)


def kept(given: Sequence[Any], wanted: dtype | None = None) -> tuple[Any, dtype]:
    """Return Python's numbers as an array keeps them, and their type: `wanted`, or that of all."""
    of = object_ if wanted is object_ else _common(given)  # which refuses sequences of sequences
    of = wanted or of
    if of is int64 and isinstance(given, range):
        return given, of
    if of is not int64 or not all(type(each) is int for each in given):
        return converted(given, of), of
    if given and not (min(given) >= -(1 << 63) and max(given) < 1 << 63):
        raise NotImplementedError("whole numbers of more than 64 bits")
    return list(given), of


def _common(given: Sequence[Any]) -> dtype:
    """Return the type of some Python numbers."""
    found = float64 if not len(given) else None
    for kind in {type(each) for each in given}:
        each = scalar_type(kind())
        found = each if found is None else promoted(found, each)
    assert found is not None
    return found


def whole(number: Any, to: dtype) -> int:  # noqa: ANN401  (a number)
    """Return a number without its fraction, as an integer of the type: more bits are cut off."""
    if number - number != 0:
        raise NotImplementedError(f"{number} as {to}")
    bits = 8 * to.itemsize
    value = int(number) & ((1 << bits) - 1)
    return value - (1 << bits) if to.kind == "i" and value >> (bits - 1) else value


def one(value: Any, to: dtype) -> Any:  # noqa: ANN401  (a number of the type)
    """Return one value in a type."""
    if to is float64:
        return float(value)  # which refuses an array; multiplied, it would stay one
    found = converted([value], to)[0]
    return found != 0 if to is bool_ else found


def converted(data: Any, to: dtype) -> Any:  # noqa: ANN401  (the values, as `ndarray` keeps them)
    """Return values in a type, as an array of this type keeps them."""
    if to is object_:
        return list(data)
    if to is bool_:
        return bytes([x != 0 for x in data])
    if to is float64:
        return [x * 1.0 for x in data]  # a zero keeps its sign
    if to.kind == "f":
        from array import array

        return array("f", data).tolist()
    bits = 8 * to.itemsize
    least, most = (
        (-(1 << (bits - 1)), (1 << (bits - 1)) - 1) if to.kind == "i" else (0, 2**bits - 1)
    )
    try:
        numbers = [int(x) for x in data]
    except (ValueError, OverflowError):
        raise NotImplementedError(f"a value that is not finite, as {to}") from None
    if numbers and (min(numbers) < least or max(numbers) > most):
        numbers = [whole(x, to) for x in numbers]
    return bytes(numbers) if to is uint8 else numbers
