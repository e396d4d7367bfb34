"""No function of the site's program imports a module that the site's Python lacks."""

from __future__ import annotations

import sys

from tools.site.imports import DESKTOP, late_imports, missing

from tools.site import packages, stdlib

# What stands in for numpy there, and what JavaScript and Pyodide hand in.
HANDED_IN = frozenset({"numpy", "mikas_host", "pyodide", "pyodide_js"})
TOPS = HANDED_IN | {
    name.partition("/")[0].removesuffix(".py")
    for name in (*packages.third_party(), packages.BUILT.replace("-", "_"))
}
OWN = packages.own()


def has(name):
    top, path = name.partition(".")[0], name.replace(".", "/")
    if top == "mikas":
        return not {f"{path}.py", f"{path}/__init__.py"}.isdisjoint(OWN)
    if top in sys.stdlib_module_names:
        return bool(stdlib.needed({f"{path}.py": b""}))
    return top in TOPS


def test_no_button_meets_an_import_that_is_missing():
    assert list(missing(OWN, has)) == []


def test_each_exception_is_one():
    """A line of the list whose import is gone, or whose package has come, is to be removed."""
    lacked = {
        (each.file, name)
        for each in late_imports(OWN)
        for name in each.names
        if not has(name) and each.is_expected(name)
    }
    for file, names in DESKTOP.items():
        for name in names:
            assert [it for at, it in lacked if at == file and f"{it}.".startswith(f"{name}.")], file


def test_what_is_reached_late_and_what_is_not():
    source = b"""\
from __future__ import annotations
import absent_at_the_head
if TYPE_CHECKING:
    import absent_for_types
class Screen:
    def press(self):
        import absent_one.part
        if True:
            from absent_two import something
        try:
            import absent_but_expected
        except ImportError:
            import absent_three
"""
    assert list(missing({"a.py": source}, lambda _: False)) == [
        "a.py:7: absent_one.part", "a.py:9: absent_two", "a.py:13: absent_three",
    ]  # fmt: skip


def test_the_modules_that_a_from_names_count():
    source = b"def f():\n    from mikas.recording.exchanges.columns import matcher, other"
    (only,) = late_imports({"mikas/a.py": source})
    package = "mikas.recording.exchanges.columns"
    assert only.names == (package, f"{package}.matcher")
