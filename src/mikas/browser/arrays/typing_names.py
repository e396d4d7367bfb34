"""What stands in the place of `numpy.typing`: names for annotations, without effect."""

from __future__ import annotations


class NDArray:
    """An array; its type of values is not looked at."""

    def __class_getitem__(cls, _: object) -> type[NDArray]:
        return cls


ArrayLike = object
