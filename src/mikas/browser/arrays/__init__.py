"""What mikas uses of numpy, in Python alone: numpy does not exist for the browser's Python.

    install() ──► sys.modules["numpy"] ──► import numpy as np      everywhere in mikas, unchanged

Results are those of numpy (tests/arrays holds them together), errors are errors, and all else of
numpy raises `NotImplementedError`: never a wrong number. Sums and means are nearer to the exact
ones than numpy's. There is no `numpy.lib`, so recorded exchanges are matched by turns.
"""

from __future__ import annotations

import sys


def install() -> None:
    """Put the arrays in numpy's place. Before anything has imported numpy."""
    from mikas.browser.arrays import names

    if sys.modules.get("numpy", names) is not names:
        raise RuntimeError("numpy is imported already")
    sys.modules["numpy"] = sys.modules["numpy.typing"] = names
