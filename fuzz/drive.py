"""One target under libFuzzer, in a process of its own: `python -m fuzz.drive TARGET [OPTION …]`.

The options are libFuzzer's. An exception of the target, a time-out, or too much memory ends the
process with a status other than 0, and the input is saved.
"""

from __future__ import annotations

import shlex
import sys
from collections.abc import Iterable
from importlib import import_module
from tempfile import NamedTemporaryFile

import atheris


def main() -> None:
    name, *options = sys.argv[1:]
    with atheris.instrument_imports(include=["mikas"]):
        target = import_module(f"fuzz.{name}")
    with NamedTemporaryFile("w", suffix=".dict") as words:
        words.write(_dictionary(target.WORDS))
        words.flush()
        # libFuzzer starts itself again to merge.
        again = f"{shlex.quote(sys.executable)} -m fuzz.drive {name}"
        atheris.Setup([again, f"-dict={words.name}", *options], target.check)
        atheris.Fuzz()


def _dictionary(words: Iterable[str]) -> str:
    """Return the words that mutations may insert, in libFuzzer's form: bytes in hexadecimal."""
    forms = ("".join(f"\\x{byte:02x}" for byte in word.encode("latin-1")) for word in words)
    return "".join(f'"{form}"\n' for form in forms)


if __name__ == "__main__":
    main()
